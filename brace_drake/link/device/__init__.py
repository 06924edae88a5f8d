"""What keeps a brace safe, tick by tick.

`guards` says what no reading may show and `release` what the legs get then;
both sides hold them: the device's own state machine (`Firmware`, as a firmware
engineer builds it in C) and the supervisor of host and simulation (`safety`).
"""

from brace_drake.link.device.firmware import Firmware
from brace_drake.link.device.guards import Trip
from brace_drake.link.device.limits_file import LoadLimits
from brace_drake.link.device.ticks import Identity, Measured

__all__ = ["Firmware", "Identity", "LoadLimits", "Measured", "Trip"]
