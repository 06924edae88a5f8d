"""What an evaluation says, in sentences made of its numbers."""

from __future__ import annotations

import numpy as np

from brace_drake.experiments.compare import SPRING_SHARE
from brace_drake.experiments.evaluate import Evaluation
from brace_drake.experiments.tables import TABLE_1_RLPIC

# A policy that tracks better than a constant does by less than this share is
# as good as it.
_MATTERS = 0.05


def explain(evaluation: Evaluation) -> list[str]:
    """Whether learning was needed, and how the paper's numbers are met."""
    said = [_on_force(evaluation)]
    for name in evaluation.policy_names:
        said += [
            _on_paper(evaluation, name),
            _on_bound(evaluation, name),
            _on_nominal_need(evaluation, name),
            _on_unseen_need(evaluation, name),
        ]
    if not evaluation.policies:
        said.append(_on_constant(evaluation))
    return said


def _on_force(evaluation: Evaluation) -> str:
    (score,) = evaluation.on_nominal("pic")
    return (
        "RMSE of the force, about its final value as the paper defines it, is"
        " no measure of smoothness for a torso that is pushed against a"
        f" spring along a cubic: it is near sqrt(13/35) = {SPRING_SHARE:.3f}"
        " of the final force whatever the controller (here"
        f" {score.force_rms:.2f} N of {score.peak_force:.2f} N with PIC). The"
        f" paper's {TABLE_1_RLPIC.force_rms} N need a force that is there from"
        " the start."
    )


def _on_paper(evaluation: Evaluation, name: str) -> str:
    scores = evaluation.on_nominal(name)
    (pic,) = evaluation.on_nominal("pic")
    parts = []
    for field, words, unit in (
        ("y_rms", "y", "mm"),
        ("vy_rms", "y'", "mm/s"),
        ("x_rms", "x", "mm"),
        ("z_rms", "z", "mm"),
    ):
        worst = max(getattr(s, field) for s in scores)
        paper = getattr(TABLE_1_RLPIC, field)
        met = "at or below" if worst <= paper else "above"
        parts.append(
            f"{words} {1e3 * worst:.3g} {unit}, {met} the paper's"
            f" {1e3 * paper:.3g} (PIC here {1e3 * getattr(pic, field):.3g})"
        )
    start = 1e3 * max(s.start_rate for s in scores)
    force = max(s.peak_force for s in scores)
    return (
        f"{name} on the nominal subject, the worst of {len(scores)}"
        f" seed{'s' if len(scores) > 1 else ''}: {'; '.join(parts)}. Start of"
        f" y' within {start:.2f} mm/s; force up to {force:.2f} N."
    )


def _on_bound(evaluation: Evaluation, name: str) -> str:
    law, scores = evaluation.benchmark.law, evaluation.on_nominal(name)
    means = [s.stiffness for s in scores]
    bound = sum(s.at_upper for s in scores)
    words = f"{min(means):.0f}"
    if len(means) > 1:
        words += f" to {max(means):.0f}"
    text = (
        f"{name} settles on {words} N/m on the nominal subject, of"
        f" {law.lower:.0f} to {law.upper:.0f} that it may choose from"
    )
    if bound == len(scores):
        return text + (
            ": the upper bound. The bound decides the stiffness, not the"
            " policy; the paper's 49 990 N/m look the same."
        )
    if bound:
        return f"{text}; {bound} of {len(scores)} seeds at the upper bound."
    return f"{text}; no seed at a bound."


def _on_constant(evaluation: Evaluation) -> str:
    own = evaluation.nominal_search
    where = ", the upper bound of its range" if own.at_upper else ""
    (score,) = evaluation.on_nominal("constant")
    return (
        "The constant of the best return on the nominal subject is"
        f" {own.best:.0f} N/m{where}: {1e3 * score.y_rms:.4f} mm along y."
    )


def _on_nominal_need(evaluation: Evaluation, name: str) -> str:
    scores = evaluation.on_nominal(name)
    error = float(np.mean([s.y_rms for s in scores]))
    violations = float(np.mean([s.violates for s in scores]))
    text = f"{_on_constant(evaluation)} {name} has {1e3 * error:.4f} mm."
    # Constants that were tried there and violate no more often.
    (best,) = evaluation.on_nominal("constant")
    tried = {evaluation.nominal_search.best: best, **evaluation.nominal_sweep}
    errors = {
        K: s.y_rms
        for K, s in tried.items()
        if s.violates <= violations and np.isfinite(s.y_rms)
    }
    if not errors:
        return (
            f"{text} No constant that was tried violates as little on the"
            " nominal subject: learning was of use for it."
        )
    stiffness = min(errors, key=errors.get)
    least = errors[stiffness]
    text += (
        " Of the constants that violate no more there, the one of the least"
        f" error is {stiffness:.0f} N/m with {1e3 * least:.4f} mm. For the"
        " nominal subject learning was "
    )
    gain = 1.0 - error / least
    if gain > _MATTERS:
        return text + f"of use: {100 * gain:.0f} % less than that."
    does = "as well" if gain > -_MATTERS else "better"
    return text + f"not needed: a search over one number does {does}."


def _on_unseen_need(evaluation: Evaluation, name: str) -> str:
    def count(who):
        return np.mean(evaluation.collect(who, "violates").sum(axis=1))

    def middle(who):
        errors = evaluation.collect(who, "y_rms")
        return np.mean(1e3 * np.median(errors, axis=1))

    constant = (
        f"the constant of the best return, {evaluation.search.best:.0f} N/m"
    )
    lines = [
        f"{words} {count(who):.1f} of {len(evaluation.subjects)} pushes beyond"
        f" a limit, median {middle(who):.3f} mm"
        for words, who in ((name, name), ("PIC", "pic"), (constant, "constant"))
    ]
    better = all(
        count(name) <= count(who) and middle(name) < middle(who)
        for who in ("pic", "constant")
    )
    dominated = [
        K
        for K, row in evaluation.sweep.items()
        if sum(s.violates for s in row) <= count(name)
        and 1e3 * np.median([s.y_rms for s in row]) <= middle(name)
    ]
    verdict = (
        "It tracks better than both and violates no more."
        if better
        else "It does not track better than both while violating no more."
    )
    if dominated:
        verdict += (
            f" A constant of {dominated[0]:.0f} N/m violates no more and"
            " tracks no worse."
        )
    else:
        verdict += " No constant of the sweep does as well in both."
    return f"On unseen subjects: {'; '.join(lines)}. {verdict}"
