"""Builds the wheel, installs it apart from the source tree, and uses it.

    python tools/smoke_wheel.py                   # a clean environment
    python tools/smoke_wheel.py --python python3.12
    python tools/smoke_wheel.py --packages DIR    # of an environment at hand
    python tools/smoke_wheel.py --demo            # and diagnoses the example

With --packages the dependencies are those of another site-packages and only
brace_drake is installed. Status 1 where a command does not end as it should.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Words of a command, and its status; {here} is an empty folder, {example} a
# copy of the bundled campaign, {data} and {policy} come with the wheel.
COMMANDS = (
    (("--version",), 0),
    (("--help",), 0),
    (("doctor",), 0),
    (("check", "{example}"), 0),
    (("check", "{here}"), 2),
    (("simulate", "{data}/bench.scenario.yaml", "--motion", "{here}/short.csv",
      "--out", "{here}/run", "--html", "{here}/run.html"), 0),
    (("personalize", "{data}/torso_girl13.measures.yaml", "--resolution",
      "0.03", "--out", "{here}/girl"), 0),
    (("plan", "--motions", "push_fast", "--effects", "force_bias", "--jobs",
      "1", "--json"), 0),
    (("predict", "{policy}"), 0),
    (("validate", "--out", "{here}/validate"), 2),
    (("completion", "bash"), 0),
)  # fmt: skip
DEMO = ((("diagnose", "{example}", "--out", "{here}/demo"), 0),)
_INSIDE = (
    "import brace_drake; from brace_drake.core.resources import *;"
    "print(brace_drake.__path__[0]); print(scenario_path(''));"
    "print(policy_path())"
)


def run(words, folder, must=False):
    """A process far from the source tree."""
    env = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    words = [str(word) for word in words]
    done = subprocess.run(
        words, cwd=folder, env=env, text=True, capture_output=True
    )
    if must and done.returncode:
        sys.exit(f"{' '.join(words)}: {done.stderr}")
    return done


def build(python: str, folder: Path) -> Path:
    """The wheel of this source tree."""
    pip = [python, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", folder]
    run([*pip, ROOT], folder, must=True)
    return next(folder.glob("*.whl"))


def install(python: str, wheel: Path, folder: Path, packages: str) -> Path:
    """An environment with the wheel; its Python."""
    run([python, "-m", "venv", folder / "env"], folder, must=True)
    inside = folder / "env" / "bin" / "python"
    pip = [inside, "-m", "pip", "install", "--quiet"]
    if packages:
        code = "import site; print(site.getsitepackages()[0])"
        site = run([inside, "-c", code], folder, must=True)
        # Behind its own, so that the wheel comes first.
        (Path(site.stdout.strip()) / "zz_shared.pth").write_text(packages)
        pip += ["--no-deps", "--ignore-installed"]
    run([*pip, wheel, "-c", ROOT / "constraints.txt"], folder, must=True)
    return inside


def main() -> int:
    """Builds, installs, runs; prints a line for each command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", default=sys.executable)
    parser.add_argument("--packages", default="")
    parser.add_argument("--demo", action="store_true")
    args = parser.parse_args()
    bad = 0
    with tempfile.TemporaryDirectory() as name:
        here = Path(name)
        wheel = build(args.python, here)
        inside = install(args.python, wheel, here, args.packages)
        places = run([inside, "-c", _INSIDE], here, must=True).stdout.split()
        package, data, policy = places
        print(f"package: {package}\ndata: {data}\npolicy: {policy}")
        bad += not all(Path(p).is_relative_to(here) for p in places)
        shutil.copytree(ROOT / "tests" / "data" / "example", here / "example")
        lines = (Path(data) / "paper_push.csv").read_text().splitlines()
        (here / "short.csv").write_text("\n".join(lines[:20]) + "\n")
        names = {"here": here, "example": here / "example", "data": data}
        names["policy"] = policy
        for words, status in COMMANDS + DEMO * args.demo:
            words = [w.format(**names) for w in words]
            begun = time.monotonic()
            done = run([inside.parent / "brace-drake", *words], here)
            good = done.returncode == status and "Traceback" not in done.stderr
            bad += not good
            spent = time.monotonic() - begun
            verdict = "good" if good else f"BAD, status {done.returncode}"
            print(f"{verdict} {spent:5.1f} s  brace-drake {words[0]}")
            if not good:
                print(done.stdout[-500:], done.stderr[-2000:])
    print(f"bad: {bad}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
