"""Writes the articulated brace's SDF and directives from a scenario.

python tools/write_brace_models.py [--scenario FILE] [--out FOLDER]
"""

import argparse
import sys
from pathlib import Path

from brace_drake.core.errors import BraceError, ScenarioError
from brace_drake.core.resources import scenario_path
from brace_drake.model.articulated import WriteBraceModels
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.load import LoadScenario

SDF = Path(__file__).resolve().parents[1] / "sdf"


def main() -> int:
    """Writes, and prints the names of the files."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = str(scenario_path("brace.scenario.yaml"))
    parser.add_argument("--scenario", default=default)
    parser.add_argument("--out", default=str(SDF))
    args = parser.parse_args()
    try:
        scenario = LoadScenario(args.scenario)
        if not isinstance(scenario, BraceScenario):
            raise ScenarioError(
                f"{args.scenario}: device is {scenario.device!r}; allowed:"
                " 'brace'"
            )
        for path in WriteBraceModels(scenario, Path(args.out)):
            print(path)
    except BraceError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
