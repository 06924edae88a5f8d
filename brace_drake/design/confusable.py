"""Pairs of effects that recordings hardly tell apart, each with the reason.

Listed once, here: the plan prints the reason, and tests/test_plan.py holds the
list against the signatures of the whole library.
"""

from __future__ import annotations

from brace_drake.effects.card import Effect

# On common motions |cos| between the signatures is above about 0.75.
ALIKE: dict[frozenset[str], str] = {
    frozenset(("coulomb_friction", "stribeck_friction")): (
        "both step at every reversal; the extra force near standstill shows"
        " only while a leg passes the Stribeck velocity: slow and fast"
        " reversals side by side tell them apart"
    ),
    frozenset(("force_gain", "ring_mass")): (
        "without load both are an error of the force that carries the ring's"
        " weight; a deep push, whose force the gain scales and the mass does"
        " not, tells them apart"
    ),
    frozenset(("force_bias", "force_drift")): (
        "over runs of one length a ramp of the force reading looks much like"
        " its mean; a run five times as long tells them apart"
    ),
    frozenset(("force_gain", "force_deadzone")): (
        "legs that always pull one way lose a force in either case, and their"
        " forces hardly vary; a deep push tells a share from a constant"
    ),
    frozenset(("ring_mass", "force_deadzone")): (
        "both are a constant error of the force that carries the ring's"
        " weight; a push that unloads some legs tells them apart"
    ),
}


def reason_of(first: Effect, second: Effect) -> str:
    """Why two effects look alike, or what the cards say of the other."""
    listed = ALIKE.get(frozenset((first.name, second.name)))
    if listed:
        return listed
    for one, other in ((first, second), (second, first)):
        if other.name in one.contains:
            return (
                f"{other.name} is a part of {one.title}: what the rest of it"
                f" does tells them apart; shown best by: {one.experiment}"
            )
        told = one.impostors.get(other.name)
        if told:
            return f"seen from {one.name}, {other.name}: {told}"
    return (
        "these motions load both in the same way; shown best by:"
        f" {first.experiment}; {second.experiment}"
    )
