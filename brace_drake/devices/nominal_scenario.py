"""Which scenario a campaign is compared with, and who has named it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from brace_drake.core.errors import ScenarioError, quoted, suggest
from brace_drake.core.reading import ReadBytes, in_file, parse_yaml
from brace_drake.devices.choice import Choice
from brace_drake.recording.manifest import MANIFEST
from brace_drake.recording.recording import Campaign
from brace_drake.scenario.load import ESTIMATION, make_scenario, scenario_text

CALLER, PACKAGE = "caller", "package"
_MOST_MB = 4


@dataclass(frozen=True)
class NominalScenario:
    """The scenario of a nominal twin.

    Attributes:
        scenario: None: the one that comes with the package, or that the
            recording itself gives.
        file: Its file; None without.
        named_by: caller, campaign.yaml or package.
        sha256: Of the file's content; None without a file.
        choice: What the file says of the fit, see `devices.choice`.
    """

    scenario: Any = None
    file: str | None = None
    named_by: str = PACKAGE
    sha256: str | None = None
    choice: Choice = field(default_factory=Choice)

    def describe(self, used: Any) -> dict:
        """For the provenance of a result.

        Args:
            used: The scenario of the twin: without a file its hash is of the
                file that it would be saved as.
        """
        return {
            "file": self.file,
            "named_by": self.named_by,
            "sha256": self.sha256 or scenario_hash(used),
        }


def choose_scenario(campaign: Campaign, given: Any = None) -> NominalScenario:
    """The scenario of a campaign: a caller's, else the one that it names.

    Args:
        campaign: Loaded.
        given: A caller's: path of a file, a scenario, or what this function
            returned before; None: none.

    Raises:
        ScenarioError: One line: file, key path, value, what is allowed.
    """
    if isinstance(given, NominalScenario):
        return given
    if given is not None:
        return load_given(given)
    named = campaign.scenario
    if named is None:
        return NominalScenario()
    path = campaign.path / named.name
    return _parse(named.data, str(path), named.name, MANIFEST)


def load_given(given: Any) -> NominalScenario:
    """A caller's scenario, from its file where it is a path.

    Raises:
        ScenarioError: One line: file, key path, value, what is allowed.
    """
    if not isinstance(given, str | Path):
        return NominalScenario(given, None, CALLER)
    with in_file(given, ScenarioError):
        data = ReadBytes(given, _MOST_MB)
    return _parse(data, str(given), str(given), CALLER)


def _parse(data: bytes, path: str, file: str, by: str) -> NominalScenario:
    with in_file(path, ScenarioError):
        content = parse_yaml(data)
    choice = Choice()
    if ESTIMATION in content:
        choice = parse_choice(content[ESTIMATION], path)
    scenario = make_scenario(content, path)
    digest = hashlib.sha256(data).hexdigest()
    return NominalScenario(scenario, file, by, digest, choice)


def scenario_hash(scenario: Any) -> str | None:
    """SHA-256 of the file that a scenario would be saved as; None of another
    package's that cannot be saved.
    """
    try:
        text = scenario_text(scenario)
    except (TypeError, ValueError, AttributeError):
        return None
    return hashlib.sha256(text.encode()).hexdigest()


def parse_choice(data: object, source: str) -> Choice:
    """The block `estimation` of a scenario file, with one or more of these:

        estimation:
          free: [contact_stiffness_N_m, preload_m]
          fixed: {posture_damping_y_N_s_m: 300}
          bounds: {preload_m: [5e-4, 2e-3], coulomb_friction.coulomb_N: [0, 2]}
          priors: {torso_mass_kg: {value: 31.5, tolerance: 2}}

    Args:
        data: As YAML has it.
        source: The file, for errors.

    Raises:
        ScenarioError: One line: file, key, value, what is allowed.
    """
    if not isinstance(data, dict):
        raise _wrong(source, "", data, "a map of keys")
    readers = {
        "free": _names,
        "fixed": _values,
        "bounds": _bounds,
        "priors": _priors,
    }
    found = {}
    for key, value in data.items():
        if key not in readers:
            hint = suggest(key, readers)
            path = f"{ESTIMATION}.{key}"
            raise ScenarioError(f"{source}: {path}: no such key{hint}")
        found[key] = readers[key](source, key, value)
    return Choice(**found)


def _names(source: str, key: str, value: object) -> tuple[str, ...]:
    is_list = isinstance(value, list) and all(isinstance(v, str) for v in value)
    if not is_list or not value:
        raise _wrong(source, key, value, "a list of names")
    return tuple(value)


def _values(source: str, key: str, value: object) -> dict[str, float | None]:
    if not isinstance(value, dict) or not all(
        v is None or _is_number(v) for v in value.values()
    ):
        raise _wrong(source, key, value, "a map of numbers by name")
    return {str(n): v if v is None else float(v) for n, v in value.items()}


def _bounds(
    source: str, key: str, value: object
) -> dict[str, tuple[float, float]]:
    if not isinstance(value, dict) or not all(
        isinstance(v, list) and len(v) == 2 and all(map(_is_number, v))
        for v in value.values()
    ):
        raise _wrong(source, key, value, "a map of [lower, upper] by name")
    return {str(n): (float(v[0]), float(v[1])) for n, v in value.items()}


def _priors(
    source: str, key: str, value: object
) -> dict[str, tuple[float, float]]:
    keys = "value", "tolerance"
    if not isinstance(value, dict) or not all(
        isinstance(v, dict)
        and set(v) == set(keys)
        and all(map(_is_number, v.values()))
        for v in value.values()
    ):
        allowed = "a map of {value: NUMBER, tolerance: NUMBER} by name"
        raise _wrong(source, key, value, allowed)
    return {
        str(n): (float(v["value"]), float(v["tolerance"]))
        for n, v in value.items()
    }


def _is_number(value: object) -> bool:
    return type(value) in (int, float)


def _wrong(source: str, key: str, value: object, allowed: str) -> ScenarioError:
    path = f"{ESTIMATION}.{key}" if key else ESTIMATION
    return ScenarioError(
        f"{source}: {path} is {quoted(value)}; allowed: {allowed}"
    )
