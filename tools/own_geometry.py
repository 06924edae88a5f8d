"""Records the bench of the guide on own geometry, for its worked example.

    python tools/own_geometry.py --out out/own

The scenario is the one that docs/guides/own_geometry.md shows. The machine has
tissue that relaxes under the pads, and is off by draw 7 of its tolerances.
Written are my_bench.scenario.yaml and the campaign, a folder of five runs.
"""

import argparse
import dataclasses
import re
import sys
import tempfile
from pathlib import Path

from brace_drake.cli.main import main as run_command
from brace_drake.recording import LoadCampaign, WriteCampaign

GUIDE = Path(__file__).parents[1] / "docs" / "guides" / "own_geometry.md"
_EFFECT = """
effects:
- name: relaxation
  parameters: {arm_stiffness_N_m: 3900, relaxation_time_s: 1.7}
"""
_MOTIONS = ("free_multisine", "push", "stairs", "multisine", "push_fast")
_VALIDATION = "push_fast"


def shown_scenario() -> str:
    """The scenario of the guide, its first block of YAML."""
    found = re.search(r"```yaml\n(.*?)```", GUIDE.read_text(), re.DOTALL)
    return found.group(1)


def record(scenario: Path, folder: Path) -> None:
    """Records every motion with the drawn machine; writes one campaign."""
    runs = []
    with tempfile.TemporaryDirectory() as name:
        for seed, motion in enumerate(_MOTIONS, start=1):
            out = Path(name) / motion
            words = ["simulate", str(scenario), "--motion", motion]
            words += ["--tolerances", "7", "--noise-seed", str(seed)]
            if run_command([*words, "--out", str(out)]):
                sys.exit(f"{motion} was not recorded")
            campaign = LoadCampaign(out)
            split = "validation" if motion == _VALIDATION else "fit"
            runs.append(dataclasses.replace(campaign.runs[0], split=split))
    whole = dataclasses.replace(campaign, path=folder, runs=tuple(runs))
    WriteCampaign(whole, folder)


def main() -> None:
    """Writes scenario and campaign, and says what to run next."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    shown, real = out / "my_bench.scenario.yaml", out / "real.scenario.yaml"
    shown.write_text(shown_scenario())
    real.write_text(shown_scenario() + _EFFECT)
    record(real, out / "campaign")
    options = f"--scenario {shown} --out {out / 'results'}"
    print(f"brace-drake diagnose {out / 'campaign'} {options}")


if __name__ == "__main__":
    main()
