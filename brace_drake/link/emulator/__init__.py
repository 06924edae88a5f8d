"""A brace that is not there: compiled laws, firmware and line in real time.

A host that opens its pseudo-terminal cannot tell it from a device; line, drives
and readings fail on demand.
"""

from brace_drake.link.emulator.bench_plant import BenchPlant
from brace_drake.link.emulator.brace_plant import BracePlant
from brace_drake.link.emulator.describe import describe_device
from brace_drake.link.emulator.device import EmulatedDevice
from brace_drake.link.emulator.make import MakePlant

__all__ = [
    "BenchPlant",
    "BracePlant",
    "EmulatedDevice",
    "MakePlant",
    "describe_device",
]
