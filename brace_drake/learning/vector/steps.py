"""What a step of many episodes comes to."""

from __future__ import annotations

import numpy as np


class Steps:
    """What a step of all episodes comes to.

    Attributes:
        rewards, terminated, truncated: (n,).
        terms, stiffness, clipped: Of info, of all episodes.
        plain: Episodes that have nothing but these in their info (n,).
        infos: Of the others.
    """

    def __init__(self, n: int):
        self.rewards = np.zeros(n)
        self.terminated, self.truncated = np.zeros((2, n), dtype=bool)
        self.plain = np.zeros(n, dtype=bool)
        self.infos: dict[int, dict] = {}
        self.terms: dict[str, np.ndarray] = {}
        self.stiffness = self.clipped = np.zeros(n)

    def InfoOf(self, i: int) -> dict:
        """Info of one episode, as the single env has it."""
        return {
            "reward_terms": {k: float(v[i]) for k, v in self.terms.items()},
            "stiffness": self.stiffness[i].copy(),
            "clipped": int(self.clipped[i]),
        }

    def AsInfos(self) -> dict:
        """Infos of the plain episodes, as a vector env gives them."""
        plain = self.plain
        if not plain.any():
            return {}
        return _masked(
            {
                "reward_terms": _masked(self.terms, plain),
                "stiffness": self.stiffness,
                "clipped": self.clipped,
            },
            plain,
        )


def _masked(values: dict, mask: np.ndarray) -> dict:
    """Values where a mask holds, else 0, each with its mask behind it."""
    infos = {}
    for name, value in values.items():
        if not isinstance(value, dict):
            own, value = value, np.zeros_like(value)
            value[mask] = own[mask]
        infos[name], infos[f"_{name}"] = value, mask.copy()
    return infos
