"""Searches that go on side by side, so that what they ask for comes at once.

    answers = together([search_a, search_b], answer)

Each search is a plain function that asks by `ask(question)`. All go on until
each has asked or ended; `answer` then takes the questions of all of them. So a
search is written as if it were alone, and what is cheaper by the dozen is done
by the dozen. One runs at a time, in the order given: nothing depends on chance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from greenlet import getcurrent, greenlet

Answer = Callable[[list[Any]], Sequence[Any]]


def ask(question: Any, answer: Answer) -> Any:
    """The answer to a question: at once, or with those of searches that go on
    side by side with the one that asks.

    Args:
        question: Whatever `answer` takes.
        answer: Answers to a list of questions, in their order.
    """
    current = getcurrent()
    if isinstance(current, _Search):
        return current.parent.switch(question)
    return answer([question])[0]


class _Search(greenlet):
    """One of several searches."""


def together(
    searches: Sequence[Callable[[], Any]], answer: Answer
) -> list[Any]:
    """Results of functions, whose questions are answered together.

    Within a search they are called one after the other.

    Args:
        searches: Functions, see the module.
        answer: As `ask` takes it.

    Raises:
        Exception: Of the first that raised one; the others end there.
    """
    if isinstance(getcurrent(), _Search):
        return [search() for search in searches]
    running = [_Search(search) for search in searches]
    said = {i: one.switch() for i, one in enumerate(running)}
    while True:
        waiting = [i for i, one in enumerate(running) if not one.dead]
        if not waiting:
            return [said[i] for i in range(len(running))]
        answers = answer([said[i] for i in waiting])
        for i, found in zip(waiting, answers, strict=True):
            said[i] = running[i].switch(found)
