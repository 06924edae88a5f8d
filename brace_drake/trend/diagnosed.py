"""Diagnoses of campaigns, kept by the content that they were made of."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from contextlib import nullcontext
from functools import cache
from pathlib import Path
from typing import Any

from brace_drake.core.errors import BraceError, CampaignError
from brace_drake.core.output import MakeFolder, WriteJson
from brace_drake.core.parallel import Workers
from brace_drake.core.reading import LoadJson
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
    # Numba and Drake are slow to import: only where there is a campaign.
    from brace_drake.devices.nominal_scenario import choose_scenario

    campaign = LoadCampaign(folder)
    named = choose_scenario(campaign, scenario)
    date = None
    if campaign.recorded:
        date = parse_date(campaign.recorded, str(folder / MANIFEST))
    place = None if diagram else _place(campaign, named, seed)
    document = _kept(place)
    if document is None:
        with bar() as progress:
            document = _diagnose(
                campaign, workers, seed, named, diagram, progress
            )
        if place is not None:
            WriteJson(MakeFolder(place) / DIAGNOSIS, document)
    session = session_of(document, folder, str(folder))
    return session.with_date(date or session.date), document


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


def _place(campaign: Campaign, named: Any, seed: int) -> Path:
    """Folder of the cache for all that a diagnosis is made of."""
    from brace_drake.document.document import campaign_hash

    own = None
    if named.scenario is not None:
        own = named.describe(named.scenario)["sha256"]
    made_of = [
        # The sentence of a verdict has the name in it.
        campaign.name,
        campaign_hash(campaign),
        own,
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
