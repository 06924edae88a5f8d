"""From an action in -1 to 1 to a stiffness, outside of any network."""

from dataclasses import dataclass

import numpy as np

from brace_drake.scenario.fields import number, word

SCALES = ("log", "linear")


@dataclass
class ActionNumbers:
    """How actions become stiffness; the paper says neither.

    `scale` says whether the middle of the range is the arithmetic (linear) or
    the geometric mean (log) of its ends. An action moves by no more than
    `rate`, 1/s: the whole range is 2. Much faster than 1, a policy learns to
    jump between the ends, and the force with it.
    """

    scale: str = word(*SCALES)
    rate: float = number(1.0, "1/s", above=0.0, most=1e6)


@dataclass(frozen=True)
class ActionLaw:
    """Bounds and rate limit of the stiffness of k coordinates.

    Attributes:
        lower, upper: N/m.
        start: Stiffness before the first action (k,), N/m.
        scale: linear or log.
        largest: Change of an action from one decision to the next.
    """

    lower: float
    upper: float
    start: np.ndarray
    scale: str
    largest: float

    def stiffness(self, action: np.ndarray) -> np.ndarray:
        """Stiffness (k,), N/m, of actions within -1 to 1."""
        share = 0.5 * (action + 1.0)
        if self.scale == "log":
            return self.lower * (self.upper / self.lower) ** share
        return self.lower + share * (self.upper - self.lower)

    def action(self, stiffness: np.ndarray) -> np.ndarray:
        """The action of a stiffness within the bounds."""
        if self.scale == "log":
            span = np.log(self.upper / self.lower)
            share = np.log(stiffness / self.lower) / span
        else:
            share = (stiffness - self.lower) / (self.upper - self.lower)
        return 2.0 * share - 1.0

    def limit(self, action: np.ndarray, before: np.ndarray) -> np.ndarray:
        """An action cut at +-1 and brought within reach of the one before.

        What is not a number leaves the action as it was.
        """
        wanted = np.clip(action, -1.0, 1.0)
        change = np.clip(wanted - before, -self.largest, self.largest)
        return before + np.where(np.isfinite(change), change, 0.0)
