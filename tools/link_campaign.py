"""Hides an effect in an emulated device and asks whether it is found again.

    python tools/link_campaign.py --effect relaxation
    python tools/link_campaign.py --effect force_bias:force_bias_N=0.5

Three commands, as a user gives them: `emulate` with the effect, `campaign` on
its terminal, whose questions are answered here, `diagnose` on the recording.
The device's time waits for the host (`--host-paced`), so that a busy machine
records as an idle one. Status 1 where the verdict names anything but the
effect; 2 where a command fails.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

_COMMAND = (sys.executable, "-m", "brace_drake.cli.main")
# Host's patience on a machine that others share, s; the device's own holds.
_STALE = 5.0
_PRESS = "press Enter: "


class Failed(Exception):
    """A command did not do what it was asked."""


def start(*words: str) -> subprocess.Popen:
    """A command whose lines are read and written here."""
    return subprocess.Popen(
        [*_COMMAND, *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        bufsize=1,
    )


def tell(process: subprocess.Popen, line: str) -> None:
    """A line of the operator."""
    process.stdin.write(line + "\n")
    process.stdin.flush()


def record(device: subprocess.Popen, words: list[str]) -> None:
    """The guided campaign; puts the torso in and out as it asks.

    Raises:
        Failed: It stopped before its end.
    """
    guide = start("campaign", *words)
    line = ""
    while char := guide.stdout.read(1):
        line += char
        if line.endswith(_PRESS):
            tell(device, f"torso {'on' if ' in,' in line else 'off'}")
            tell(guide, "")
        elif char != "\n":
            continue
        print(f"  {line.strip()}", flush=True)
        line = ""
    if guide.wait():
        raise Failed("campaign stopped")


def diagnose(campaign: Path, out: Path, jobs: int) -> dict:
    """What the diagnosis says of a campaign.

    Raises:
        Failed: It says nothing.
    """
    words = ("diagnose", str(campaign), "--out", str(out), "--jobs", str(jobs))
    done = subprocess.run([*_COMMAND, *words], stdout=subprocess.DEVNULL)
    if done.returncode:
        raise Failed("diagnose failed")
    return json.loads((out / "diagnosis.json").read_text())["verdict"]


def try_effects(args: argparse.Namespace, folder: Path) -> dict:
    """Records from a device with the effects; the verdict.

    Raises:
        Failed: One of the commands failed.
    """
    limits = folder / "limits.yaml"
    limits.write_text(f"stale: {_STALE}\n")
    campaign, begun = folder / "campaign", time.monotonic()
    hidden = [word for text in args.effect for word in ("--effect", text)]
    device = start(
        *("emulate", "--host-paced", "10", "--seed", str(args.seed), *hidden)
    )
    try:
        port = device.stdout.readline().removeprefix("port: ").strip()
        if not port:
            raise Failed("emulate did not start")
        words = ["--port", port, "--out", str(campaign), "--countdown", "1"]
        words += ["--limits", str(limits)]
        words += ["--plan", args.plan] if args.plan else []
        record(device, words)
        tell(device, "stop")
        print(f"device: {device.stdout.read().strip()}")
    finally:
        device.kill()
        device.wait()
    took = time.monotonic() - begun
    print(f"recorded in {took:.0f} s", flush=True)
    begun = time.monotonic()
    verdict = diagnose(campaign, folder / "results", args.jobs)
    print(f"diagnosed in {time.monotonic() - begun:.0f} s")
    return verdict


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument(
        "--effect",
        action="append",
        metavar="NAME[:P=V,...]",
        help="hidden, of the library; twice at most (relaxation)",
    )
    parser.add_argument(
        "--plan", help="of runs, a file (default: the standard)"
    )
    parser.add_argument("--out", help="folder to keep all in, new")
    parser.add_argument("--seed", type=int, default=0, help="of the noise")
    parser.add_argument("--jobs", type=int, default=1)
    args = parser.parse_args()
    args.effect = args.effect or ["relaxation"]
    with tempfile.TemporaryDirectory() as own:
        folder = Path(args.out or own)
        folder.mkdir(parents=True, exist_ok=True)
        try:
            verdict = try_effects(args, folder)
        except Failed as error:
            print(f"link_campaign: {error}", file=sys.stderr)
            return 2
    print(verdict["sentence"])
    hidden = {text.partition(":")[0] for text in args.effect}
    print(f"hidden: {' + '.join(sorted(hidden))}")
    print(f"named:  {' + '.join(sorted(verdict['effects'])) or 'none'}")
    return int(set(verdict["effects"]) != hidden)


if __name__ == "__main__":
    sys.exit(main())
