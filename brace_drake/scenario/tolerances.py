"""How exactly a scenario's numbers are known: one standard deviation of each.

A file states them in its block `tolerances`, or beside a number that may carry
one: `ring: {mass: {value: 0.85, tolerance: 0.015}}`.
"""

import dataclasses
import math
from dataclasses import dataclass, fields

from brace_drake.core.errors import ScenarioError, suggest
from brace_drake.scenario.fields import fail, merge, number, read

# Numbers of a scenario that may carry a tolerance, and its name in the block.
BESIDE = {"ring.mass": "ring_mass", "leg.viscous": "leg_viscous"}
# In place of the block: all is as the numbers say.
EXACT = "exact"
_KEYS = {"value", "tolerance"}


class _Origin:
    """Where tolerances are from; not a number of a file.

    Attributes:
        is_stated: Whether somebody has stated them, as the shipped files do;
            a file without them leaves them assumed.
        named: Those that were stated one by one; the others have defaults.
    """

    # Without an annotation they are no keys of a file.
    __slots__ = ("is_stated", "named")


@dataclass(slots=True)
class Tolerances(_Origin):
    """One standard deviation of each number; 0: exactly known.

    What the numbers of a real bench differ by from its data sheet's without
    being a finding.
    """

    ring_mass: float = number(0.015, "kg", least=0.0, most=1.0)
    # Of all legs.
    leg_viscous: float = number(1.5, "N s/m", least=0.0, most=100.0)
    # Of all legs, beside none; a half normal, as every real leg has some.
    leg_dry_friction: float = number(0.03, "N", least=0.0, most=10.0)
    # Of each coordinate of each anchor.
    anchor: float = number(5.0e-5, "m", least=0.0, most=0.01)
    # Of the force reading, and of the force along y.
    force_scale: float = number(0.006, least=0.0, most=0.5)
    force_bias: float = number(0.02, "N", least=0.0, most=10.0)
    # Of all drives: so late or not at all.
    command_delay: float = number(0.001, "s", least=0.0, most=0.05)

    def __post_init__(self):
        self.is_stated = True
        self.named = frozenset()


def split_tolerances(
    scenario, data: dict, source: str
) -> tuple[dict, Tolerances | None]:
    """Tells what a file says of tolerances from its numbers.

    Args:
        scenario: That the file will be laid over.
        data: Of the file.
        source: Named in errors.

    Returns:
        The file with plain numbers and without the block; the tolerances of
        the scenario as the file has them, None where it says nothing.

    Raises:
        ScenarioError: One line: source, key path, value, what is allowed.
    """
    has_block = "tolerances" in data and hasattr(scenario, "tolerances")
    block = data["tolerances"] if has_block else {}
    beside: dict[str, float] = {}
    plain = _plain(scenario, data, source, "", beside)
    if not has_block and not beside:
        return plain, None
    if has_block:
        del plain["tolerances"]
    tolerances = dataclasses.replace(scenario.tolerances)
    if block == EXACT:
        block = dict.fromkeys((f.name for f in fields(tolerances)), 0.0)
    if not isinstance(block, dict):
        fail(source, "tolerances", block, f"{EXACT} or a map of keys")
    merge(tolerances, block, source, "tolerances")
    for path, value in beside.items():
        name = BESIDE[path]
        own = getattr(tolerances, name)
        if name in block and own != value:
            allowed = f"{own:g}, which tolerances.{name} is"
            fail(source, f"{path}.tolerance", value, allowed)
        setattr(tolerances, name, value)
    tolerances.named = scenario.tolerances.named.union(
        block, (BESIDE[path] for path in beside)
    )
    return plain, tolerances


def _plain(node, data: dict, source: str, at: str, beside: dict[str, float]):
    """The map of a dataclass with plain numbers; tolerances go to `beside`."""
    out = dict(data)
    for key, value in data.items():
        if not isinstance(value, dict) or not hasattr(node, str(key)):
            continue
        path, own = f"{at}.{key}" if at else key, getattr(node, key)
        if dataclasses.is_dataclass(own):
            out[key] = _plain(own, value, source, path, beside)
        elif not isinstance(own, dict) and _KEYS & set(value):
            out[key] = _value(own, value, source, path, beside)
    return out


def _value(own, data: dict, source: str, path: str, beside: dict[str, float]):
    """The value of a map {value, tolerance}; its tolerance goes to `beside`."""
    if path not in BESIDE:
        names = " and ".join(BESIDE)
        allowed = f"no map: of a bench or brace {names} may carry a tolerance"
        fail(source, path, data, allowed)
    for key in data:
        if key not in _KEYS:
            hint = suggest(key, _KEYS)
            raise ScenarioError(f"{source}: {path}.{key}: no such key{hint}")
    if "tolerance" in data:
        place = f"{path}.tolerance"
        beside[path] = read(float, data["tolerance"], source, place)
        if not 0.0 <= beside[path] < math.inf:
            fail(source, place, beside[path], "a finite number, 0 or more")
    return data.get("value", own)
