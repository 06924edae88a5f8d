"""The verdict in words."""

from __future__ import annotations

from brace_drake.effects.registry import find_effect

# Deepest cause first: what lies upstream explains what follows.
_MOTIONS = {
    "actuation": "free_reversal: slow reversals of direction without contact,"
    " 2 mm/s, three times",
    "mechanism": "stairs: ten steps over the full stroke, 2 s each",
    "contact": "stairs with holds of 10 s at three depths",
    "torso": "quiet_hold of 60 s in contact",
    "sensing": "quiet_hold of 10 s without contact, then a slow push",
}


def verdict_sentence(
    name: str,
    effects: list[str],
    gap: bool,
    closed: float | None,
    values: str,
) -> str:
    """One sentence that says what was found."""
    if not gap:
        return (
            f"No gap: with the subject's parameters fitted, the twin"
            f" reproduces {name} down to its noise."
        )
    if not effects:
        return (
            f"There is a gap in {name}, and no effect in the library explains"
            " it."
        )
    titles = " and ".join(find_effect(e).title for e in effects)
    text = f"The gap in {name} is {titles} ({values})"
    if closed is not None:
        text += (
            f"; adding it closes {100 * closed:.1f} % of the gap on fresh runs"
        )
    return text + "."


def next_experiment(
    effects: list[str], ambiguous: tuple[str, ...], outside: bool, ladder
) -> dict | None:
    """A motion that would settle what is open, None where nothing is."""
    if ambiguous:
        names = [*effects, *ambiguous]
        return {
            "why": "these data do not separate " + ", ".join(names),
            "motion": find_effect(effects[0]).experiment,
        }
    if outside:
        accused = [r for r in ladder if not r["acquitted"]]
        if not accused:
            return None
        worst = max(accused, key=lambda r: r["share"])["block"]
        return {
            "why": f"the largest unexplained rest lies in {worst}",
            "motion": _MOTIONS.get(worst, "repeat the runs at half speed"),
        }
    return None
