"""Diagnoses of campaigns, kept by the content that they were made of."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from contextlib import nullcontext
from functools import cache
from pathlib import Path

from brace_drake.core.errors import BraceError, CampaignError
from brace_drake.core.output import MakeFolder, WriteJson
from brace_drake.core.parallel import Workers
from brace_drake.core.reading import LoadJson, ReadBytes, in_file, parse_yaml
from brace_drake.core.resources import cache_path
from brace_drake.recording import Campaign, LoadCampaign
from brace_drake.recording.manifest import MANIFEST
from brace_drake.trend.sessions import (
    DIAGNOSIS,
    LoadSession,
    Session,
    parse_date,
    session_of,
)

_DATE = "recorded"  # key of campaign.yaml


def is_campaign(folder: Path) -> bool:
    """Whether a folder is a campaign, and holds no diagnosis.

    Raises:
        CampaignError: It holds neither.
    """
    if (folder / DIAGNOSIS).is_file():
        return False
    if (folder / MANIFEST).is_file():
        return True
    if not folder.is_dir():
        what = "is a file" if folder.exists() else "no such folder"
        raise CampaignError(f"{folder}: {what}")
    raise CampaignError(
        f"{folder}: neither {DIAGNOSIS} nor {MANIFEST} in this folder"
    )


def LoadOrDiagnose(
    folder: Path,
    workers: Workers,
    seed: int = 0,
    scenario=None,
    diagram: Callable | None = None,
    bar: Callable = nullcontext,
) -> tuple[Session, dict | None]:
    """The session of a folder.

    A campaign is diagnosed; what comes out is kept in the user's cache by the
    content of recordings, scenario, seed and code, and a second call reads it.
    With a diagram nothing is kept, as its code cannot be told.

    Args:
        folder: With diagnosis.json, or a campaign.
        workers, seed, scenario, diagram: See `diagnose`.
        bar: Makes a context of what `diagnose` tells its progress to; used
            where something is diagnosed.

    Returns:
        The session, and the document of a campaign's diagnosis.

    Raises:
        BraceError: It cannot be read or diagnosed; the message names it.
    """
    if not is_campaign(folder):
        return LoadSession(folder), None
    campaign = LoadCampaign(folder)
    date = campaign_date(folder)
    place = None if diagram else _place(campaign, scenario, seed)
    document = _kept(place)
    if document is None:
        with bar() as progress:
            document = _diagnose(
                campaign, workers, seed, scenario, diagram, progress
            )
        if place is not None:
            WriteJson(MakeFolder(place) / DIAGNOSIS, document)
    session = session_of(document, folder, str(folder))
    return session.with_date(date or session.date), document


def campaign_date(folder: Path):
    """When a campaign was recorded, by its campaign.yaml; None without.

    Raises:
        CampaignError: It is no date.
    """
    path = folder / MANIFEST
    with in_file(path, CampaignError):
        found = parse_yaml(ReadBytes(path, 4)).get(_DATE)
    return None if found is None else parse_date(found, str(path))


def _diagnose(campaign, workers, seed, scenario, diagram, progress) -> dict:
    from brace_drake.diagnosis import diagnose
    from brace_drake.document.document import MakeDocument

    try:
        found = diagnose(
            campaign,
            workers,
            seed,
            scenario,
            progress=progress,
            diagram=diagram,
        )
    except BraceError as error:
        text = str(error)
        if text.startswith(str(campaign.path)):
            raise
        raise CampaignError(f"{campaign.path}: {text}") from error
    return MakeDocument(found)


def _kept(place: Path | None) -> dict | None:
    """What was kept there; None where nothing of use is."""
    if place is None:
        return None
    try:
        found = LoadJson(place / DIAGNOSIS, CampaignError)
        session_of(found, place, str(place))
    except CampaignError:
        return None
    return found


def _place(campaign: Campaign, scenario, seed: int) -> Path:
    """Folder of the cache for all that a diagnosis is made of."""
    from pydrake.common.yaml import yaml_dump_typed

    from brace_drake.document.document import campaign_hash

    named = campaign.scenario
    made_of = [
        # The sentence of a verdict has the name in it.
        campaign.name,
        campaign_hash(campaign),
        "" if scenario is None else yaml_dump_typed(scenario),
        named.data.decode(errors="replace") if named else "",
        seed,
        _code_hash(),
    ]
    key = hashlib.sha256(json.dumps(made_of).encode()).hexdigest()
    return cache_path("diagnoses") / key[:32]


@cache
def _code_hash() -> str:
    """SHA-256 over the package's own code."""
    package = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        digest.update(str(path.relative_to(package)).encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()
