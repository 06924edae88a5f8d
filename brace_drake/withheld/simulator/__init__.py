"""An independent simulator of the physical bench, written apart from the twin.

It shares no code with the twin: other formulation, other integration, other
laws of friction and tissue. Where the twin is an idealisation of a machine,
this plays the machine. `run_bench` records a motion of `make_motions` on a
bench with a `Subject` and `Flaws`.
"""

from brace_drake.withheld.simulator.bench import (
    COLUMNS,
    REFERENCE,
    Decisions,
    run_bench,
)
from brace_drake.withheld.simulator.flaws import Flaws, with_flaws
from brace_drake.withheld.simulator.motions import (
    LOG_PERIOD,
    Motion,
    make_motions,
)
from brace_drake.withheld.simulator.numbers import TICK, Subject
from brace_drake.withheld.simulator.state import Run

__all__ = [
    "COLUMNS",
    "LOG_PERIOD",
    "REFERENCE",
    "TICK",
    "Decisions",
    "Flaws",
    "Motion",
    "Run",
    "Subject",
    "make_motions",
    "run_bench",
    "with_flaws",
]
