"""What a payoff's folder was begun with, so that nothing else goes on in it."""

from dataclasses import asdict, dataclass
from pathlib import Path

from pydrake.common.yaml import yaml_dump_typed

from brace_drake.core.errors import BraceError
from brace_drake.core.output import WriteText
from brace_drake.scenario.load import LoadRecord

FILE = "payoff.yaml"


@dataclass
class PayoffOptions:
    """Options that machines, diagnoses and trainings of a folder depend on.

    Budget and seed of the trainings are kept by these themselves. Causes may
    be added, and pushes are made anew each time.

    Attributes:
        severity: Of the faults.
        force_limit: F_max, N.
        seed: Of machines, campaigns and diagnoses.
    """

    severity: str = "large"
    force_limit: float = 20.0
    seed: int = 0


def KeepOptions(folder: Path, options: PayoffOptions) -> None:
    """Writes payoff.yaml into a new folder, or holds the options to its own.

    Raises:
        BraceError: The folder was begun with others, or holds something that
            is not a payoff's.
    """
    path = folder / FILE
    if not path.exists():
        if any(folder.iterdir()):
            raise BraceError(
                f"{folder}: holds files and no {FILE}: name a new folder"
            )
        WriteText(path, yaml_dump_typed(options))
        return
    kept = asdict(LoadRecord(PayoffOptions(), path))
    for key, value in asdict(options).items():
        if kept[key] != value:
            raise BraceError(
                f"{path}: {key}: begun with {kept[key]}, asked for is {value}:"
                " name another folder, or the same options"
            )
