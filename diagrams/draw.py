"""Draws the diagram of a scenario: systems, bodies, and each system's ports.

    python diagrams/draw.py diagrams/bench.scenario.yaml --out out/bench

`--set` lays YAML over the scenario, for instance "mechanism: articulated".
Without a scenario the drawings that lie here are drawn anew. Graphviz draws.
"""

import argparse
import sys

from brace_drake.core.errors import BraceError
from brace_drake.drawing import WriteDrawings, WriteKeptDrawings
from brace_drake.scenario.load import LoadScenario


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("scenario", metavar="SCENARIO", nargs="?")
    parser.add_argument("--out", metavar="DIR", help="folder for the drawings")
    parser.add_argument("--set", metavar="YAML", dest="overrides")
    args = parser.parse_args()
    if args.scenario and not args.out:
        parser.error("a SCENARIO needs --out DIR")
    try:
        if not args.scenario:
            print(*WriteKeptDrawings(), sep="\n")
            return 0
        scenario = LoadScenario(args.scenario, args.overrides)
        files = WriteDrawings(scenario, args.out)
    except BraceError as error:
        print(f"draw.py: {error}", file=sys.stderr)
        return 2
    print(f"{len(files)} files in {args.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
