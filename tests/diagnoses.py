"""Documents of diagnoses: of the bundled example, and others made of it."""

import copy
import json

from tests.shared_data import EXAMPLE

# tests/test_diagnose.py holds its form to that of one that is written.
STORED = json.loads(
    (EXAMPLE.parent / "example_diagnosis" / "diagnosis.json").read_text()
)


def make_diagnosis() -> dict:
    """The diagnosis of the bundled example: one effect, all explained."""
    return copy.deepcopy(STORED)


def make_partly() -> dict:
    """Its effect is certain, and explains a part of the gap alone."""
    diagnosis = make_diagnosis()
    verdict, shrink = diagnosis["verdict"], diagnosis["shrink"]
    verdict |= {
        "outside_library": True,
        "unexplained": {
            "share": 0.31,
            "block": "actuation",
            "description": "goes with the size of the speed, as a damper would",
            "law": None,
        },
    }
    closes = verdict["supported"][0]["closes"] = 0.68
    verdict["supported"][0]["closes_interval"] = [0.66, 0.7]
    title = verdict["supported"][0]["title"]
    verdict["blocks"] = [*verdict["blocks"], "actuation"]
    verdict["sentence"] = (
        f"{title} is there (p 0.97) and explains 68.0 % of the gap in example;"
        " 31.0 % is left, in actuation, and goes with the size of the speed."
    )
    chosen = next(c for c in diagnosis["causes"] if c["chosen"])
    after = 1.0 + (1.0 - closes) * (shrink["before"] - 1.0)
    chosen |= {"excess": after**2 - 1.0, "held_out": after**2 - 1.0}
    chosen["explained"] = closes
    chosen["validation"]["gap"] = after
    shrink |= {"after": after, "closed": closes}
    shrink["closed_interval"] = [0.66, 0.7]
    diagnosis["left"] = [make_rest()]
    diagnosis["tolerances"] = [
        {
            "name": "ring_mass_kg",
            "unit": "kg",
            "block": "mechanism",
            "tolerance": 0.015,
            "value": -0.0412,
            "standard_error": 0.0031,
            "deviations": -2.75,
        }
    ]
    return diagnosis


def make_rest() -> dict:
    """A row of what is left."""
    return {
        "channel": "ring2_force_y_N",
        "normalised_rms": 2.5,
        "share_of_rest": 1.0,
        "shape": "size of the speed",
        "acts_like": "a damper that is not the same in both directions",
        "takes": 0.74,
        "lower95": 0.69,
        "upper95": 0.79,
    }


def make_unexplained() -> dict:
    """One whose gap no effect explains, with every part that this brings."""
    diagnosis = make_diagnosis()
    verdict = diagnosis["verdict"]
    verdict |= {
        "effects": [],
        "supported": [],
        "outside_library": True,
        "unexplained": {
            "share": 1.0,
            "block": "contact",
            "description": "goes with the size of the speed, as a damper would",
            "law": None,
        },
    }
    verdict["sentence"] = (
        "There is a gap in example, and no effect in the library explains it;"
        " 100 % is left, in contact."
    )
    for cause in diagnosis["causes"]:
        cause["chosen"] = False
    shrink = diagnosis["shrink"]
    for row in (shrink, *shrink["channels"]):
        row |= {"after": row["before"], "closed": None}
    shrink["closed_interval"] = None
    row = make_rest()
    diagnosis["left"] = [row, {**row, "shape": None, "acts_like": None}]
    diagnosis["next_experiment"] = {
        "why": "Hysteresis and relaxation differ most while nothing moves.",
        "motion": "hold",
        "file": "next_run.csv",
        "pairs": [
            {"effects": ["hysteresis", "relaxation"], "separation": 144.0}
        ],
    }
    diagnosis["warnings"] = ["no run was repeated"]
    return diagnosis


def make_withdrawn() -> dict:
    """One whose effect is contradicted by the validation runs."""
    diagnosis = make_unexplained()
    why = (
        "on the validation runs relaxation would change the gap from 2.49 to"
        " 2.61 times the floor"
    )
    diagnosis["verdict"] |= {
        "confirmed": False,
        "contradicted": why,
        "probability": 0.05,
        "sentence": "There is a gap in example, and nothing that explains it"
        f" is confirmed: {why}.",
    }
    diagnosis["warnings"] = [f"withdrawn: {why}"]
    return diagnosis


def make_partly_withdrawn() -> dict:
    """One of whose two effects the validation runs contradict one."""
    diagnosis = make_diagnosis()
    verdict = diagnosis["verdict"]
    why = (
        "backlash (actuation) makes the validation runs worse: it closes"
        " -12.0 % of their gap, 95 % of -15.0 to -9.0 %"
    )
    verdict |= {
        "confirmed": False,
        "contradicted": why,
        "probability": 0.05,
        "sentence": f"{verdict['sentence']} Withdrawn: {why}.",
    }
    diagnosis["warnings"] = [f"withdrawn: {why}"]
    return diagnosis


def make_without_gap() -> dict:
    """One that has no gap, and no validation runs."""
    diagnosis = make_diagnosis()
    diagnosis["verdict"] |= {
        "gap": False,
        "effects": [],
        "supported": [],
        "blocks": [],
        "confirmed": None,
        "unexplained": {
            "share": 0.0,
            "block": None,
            "description": "",
            "law": None,
        },
        "sentence": "No gap: with the subject's parameters fitted, the twin"
        " reproduces example down to its noise.",
    }
    for cause in diagnosis["causes"]:
        cause["chosen"] = False
    diagnosis["shrink"] = None
    diagnosis["where"] |= {"attribution": [], "cube": []}
    return diagnosis


ALL = (
    make_diagnosis,
    make_partly,
    make_unexplained,
    make_withdrawn,
    make_partly_withdrawn,
    make_without_gap,
)
