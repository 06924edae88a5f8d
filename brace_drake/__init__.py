"""Digital twin of a robotic scoliosis brace that says why it differs.

    import brace_drake as bd

    d = bd.diagnose("campaigns/monday")
    d.to_pandas("causes")
    d.repaired.simulate("push")

Importing the package costs nothing: what a name stands for is imported when it
is first asked for.
"""

from __future__ import annotations

# As of typing, which would take longer to import than all of this.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from brace_drake.core.errors import BraceError
    from brace_drake.recording.recording import Campaign, Run
    from brace_drake.results.campaigns import load
    from brace_drake.results.diagnoses import DiagnosisResult, diagnose
    from brace_drake.results.fits import FitResult, fit
    from brace_drake.results.plans import PlanResult, plan
    from brace_drake.results.repaired import RepairedTwin

__all__ = [
    "BraceError",
    "Campaign",
    "DiagnosisResult",
    "FitResult",
    "PlanResult",
    "RepairedTwin",
    "Run",
    "diagnose",
    "fit",
    "load",
    "plan",
]

# Where each name is from. None of them may be a module of this folder: who
# imports such a module would put it in the place of the name.
_PLACES = {
    "BraceError": "core.errors",
    "Campaign": "recording.recording",
    "DiagnosisResult": "results.diagnoses",
    "FitResult": "results.fits",
    "PlanResult": "results.plans",
    "RepairedTwin": "results.repaired",
    "Run": "recording.recording",
    "diagnose": "results.diagnoses",
    "fit": "results.fits",
    "load": "results.campaigns",
    "plan": "results.plans",
}


def __getattr__(name: str) -> object:
    import importlib

    if name == "__version__":
        import importlib.metadata

        return importlib.metadata.version("brace_drake")
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = importlib.import_module(f"{__name__}.{_PLACES[name]}")
    globals()[name] = value = getattr(module, name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"})
