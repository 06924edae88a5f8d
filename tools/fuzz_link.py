"""Damages frames between an armed device and its host; looks what they do.

    python tools/fuzz_link.py --frames 1000000 --seed 1
    python tools/fuzz_link.py --frames 1000000 --way to-host

Frames are corrupted, truncated, duplicated, reordered, dropped, mixed with
noise, and forged (random content under a good CRC). Status 1 where anything
raises or an undamaged frame behind a damaged one is lost; to the device where a
command is accepted that was not sent as it is; to the host where a command
leaves that is no number or beyond its limits, or where more damage passes for a
state than a CRC-16 lets through.
"""

import argparse
import sys
import time

from link_fuzz.to_device import ToDevice
from link_fuzz.to_host import ToHost

_WAYS = {"to-device": ToDevice, "to-host": ToHost}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--frames", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--way", choices=_WAYS, default="to-device")
    args = parser.parse_args()
    fuzz, begun = _WAYS[args.way](args.seed), time.perf_counter()
    for _ in range(args.frames):
        fuzz.step()
    seconds = time.perf_counter() - begun
    for name, number in fuzz.counts.items():
        print(f"{name:12} {number}")
    bad = {k: v for k, v in fuzz.decoder.bad.items() if v}
    print(f"not messages {bad}")
    print(f"buffer       {len(fuzz.decoder._rest)} bytes")
    is_bad = fuzz.report()
    print(f"took         {seconds:.0f} s")
    return int(is_bad)


if __name__ == "__main__":
    sys.exit(main())
