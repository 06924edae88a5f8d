"""What a policy's file must hold, array by array, before any is used."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brace_drake.core.errors import (
    EffectError,
    PolicyError,
    ReadError,
    ScenarioError,
)
from brace_drake.core.errors import quoted as quote
from brace_drake.core.reading import HUGE, parse_yaml
from brace_drake.core.reading.arrays import ReadArrays
from brace_drake.learning.actions import SCALES, ActionLaw
from brace_drake.learning.signals import observation_size
from brace_drake.learning.task import LearningTask, check_numbers
from brace_drake.scenario.fields import merge

FORMAT = 1
_MOST_LAYERS, _MOST_OUTPUTS = 20, 100_000


class PolicyFile:
    """A policy's arrays; each is checked where it is taken."""

    def __init__(self, path: str | Path):
        self._path = path
        try:
            self._arrays = ReadArrays(path)
        except ReadError as error:
            what = "is not a policy (*.npz of `brace-drake train`): "
            told = str(error).startswith("cannot be read")
            raise PolicyError(f"{path}: {what * (not told)}{error}") from error
        found = self._arrays.get("format", np.array("none"))
        if found.ndim or found.tolist() != FORMAT:
            self.fail("format", found, str(FORMAT))

    def fail(self, name: str, value, allowed: str):
        """Refuses the file.

        Raises:
            PolicyError: One line: file, array, value, what is allowed.
        """
        value = value.tolist() if isinstance(value, np.ndarray) else value
        raise PolicyError(
            f"{self._path}: {name} is {quote(value)}; allowed: {allowed}"
        )

    def numbers(
        self,
        name: str,
        shape: tuple[int, ...],
        low: float = -HUGE,
        high: float = HUGE,
    ) -> np.ndarray:
        """Numbers of a shape, between two (these included).

        Raises:
            PolicyError: The array is not that.
        """
        found = self._take(name)
        if found.dtype.kind not in "fiu":
            self.fail(name, found, "numbers")
        if found.shape != shape:
            sizes = " x ".join(map(str, shape)) or "one"
            self.fail(f"the shape of {name}", found.shape, f"{sizes} numbers")
        found = found.astype(float)
        # Written so that NaN fails.
        wrong = ~((low <= found) & (found <= high))
        if wrong.any():
            self.fail(
                name, found[wrong][0], f"numbers from {low:g} to {high:g}"
            )
        return found

    def number(self, name: str, low: float, high: float = HUGE) -> float:
        """One number between two."""
        return float(self.numbers(name, (), low, high))

    def _take(self, name: str) -> np.ndarray:
        if name not in self._arrays:
            raise PolicyError(f"{self._path}: not a policy: no {name}")
        return self._arrays[name]

    def text(self, name: str) -> str:
        """One text."""
        found = self._take(name)
        if found.ndim or found.dtype.kind != "U":
            self.fail(name, found, "text")
        return str(found)

    def take_task(self, size: int) -> LearningTask:
        """What the policy was trained for, on a brace of `size` coordinates."""
        task, source = LearningTask(), f"{self._path}: task"
        try:
            merge(task, parse_yaml(self.text("task")), source)
            check_numbers(task, size // 6, source)
        except ReadError as error:
            raise PolicyError(f"{source}: {error}") from error
        except (ScenarioError, EffectError) as error:
            raise PolicyError(str(error)) from error
        return task

    def take_selected(self) -> np.ndarray:
        """Coordinates with an impedance (6n,), bool."""
        found = self._take("selected")
        good = found.ndim == 1 and found.dtype.kind == "b"
        if not (good and len(found) in (6, 12, 18) and found.any()):
            self.fail("selected", found, "true or false of 6, 12 or 18")
        return found

    def take_law(self, outputs: int) -> ActionLaw:
        """Bounds and rate of the stiffness of so many coordinates."""
        lower = self.number("law_lower", 1e-6)
        upper = self.number("law_upper", lower)
        scale = self.text("law_scale")
        if scale not in SCALES or upper == lower:
            self.fail("law_scale", scale, " or ".join(SCALES))
        return ActionLaw(
            lower=lower,
            upper=upper,
            start=self.numbers("law_start", (outputs,), lower, upper),
            scale=scale,
            largest=self.number("law_largest", 1e-9, 2.0 * _MOST_LAYERS),
        )

    def take_layers(self, inputs: int, outputs: int):
        """Weights and biases of each layer, which fit each other."""
        weights: list[np.ndarray] = []
        biases: list[np.ndarray] = []
        while f"W{len(weights)}" in self._arrays:
            i = len(weights)
            rows = self._take(f"W{i}").shape[:1]
            if i == _MOST_LAYERS or not 0 < sum(rows) <= _MOST_OUTPUTS:
                self.fail(f"the shape of W{i}", rows, "layers of a network")
            try:
                weights.append(self.numbers(f"W{i}", (*rows, inputs)))
                biases.append(self.numbers(f"b{i}", rows))
            except PolicyError as error:
                raise PolicyError(f"{error} in layer {i}") from error
            (inputs,) = rows
        if not weights or inputs != outputs:
            found = inputs if weights else "no layer"
            allowed = f"{outputs}, as there are stiffnesses"
            self.fail("the number of outputs", found, allowed)
        single = np.float32
        return (
            tuple(W.astype(single, copy=False) for W in weights),
            tuple(b.astype(single, copy=False) for b in biases),
        )

    def size_of_observation(self, task: LearningTask, size: int) -> int:
        """Numbers that the policy sees, of a brace with `size` coordinates."""
        if task.observation == "stage" and size != 6:
            self.fail("selected", size, "6, as the task observes one stage")
        return observation_size(task.observation, size)
