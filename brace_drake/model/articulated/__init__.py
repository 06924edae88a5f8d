"""The brace with its 18 legs as bodies, from one scenario's numbers."""

from brace_drake.model.articulated.models import WriteBraceModels, make_models
from brace_drake.model.articulated.plant import (
    AddArticulatedBrace,
    GetClosures,
    GetDrives,
    SetLegs,
    calc_closure_error,
)

__all__ = [
    "AddArticulatedBrace",
    "GetClosures",
    "GetDrives",
    "SetLegs",
    "WriteBraceModels",
    "calc_closure_error",
    "make_models",
]
