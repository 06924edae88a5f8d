"""A trained policy on numpy alone: its network, scaling, bounds, and task."""

from __future__ import annotations

import io
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed
from yaml import YAMLError

from brace_drake.core.errors import PolicyError, reason
from brace_drake.core.output import WriteBytes
from brace_drake.learning.actions import ActionLaw
from brace_drake.learning.signals import OBSERVERS, signals_of_estimate
from brace_drake.learning.task import LearningTask

FORMAT = 1


@dataclass(frozen=True)
class Policy:
    """The mean of the actor: tanh(W_3 relu(W_2 relu(W_1 o + b_1) + b_2) + b_3).

    o is the observation minus `mean`, times `gain`, cut at +-`clip`. The
    network works in single precision, as it was trained.

    Attributes:
        weights, biases: Of each layer, (outputs, inputs) and (outputs,).
        mean, gain: Of the observation (m,).
        clip: Of the scaled observation.
        law: Bounds and rate limit of the stiffness, outside of the network.
        selected: Coordinates with an impedance (6n,), bool.
        task: What it was trained for.
    """

    weights: tuple[np.ndarray, ...]
    biases: tuple[np.ndarray, ...]
    mean: np.ndarray
    gain: np.ndarray
    clip: float
    law: ActionLaw
    selected: np.ndarray
    task: LearningTask

    def act(self, observation: np.ndarray) -> np.ndarray:
        """The action (k,), within -1 to 1, of an observation (m,), SI."""
        x = (observation - self.mean) * self.gain
        x = np.minimum(np.maximum(x, -self.clip), self.clip)
        x = x.astype(np.float32)
        for W, b in zip(self.weights[:-1], self.biases[:-1], strict=True):
            x = np.maximum(W @ x + b, np.float32(0.0))
        return np.tanh(self.weights[-1] @ x + self.biases[-1]).astype(float)

    def act_on(self, estimate: np.ndarray, desired: np.ndarray) -> np.ndarray:
        """The action on what a controller knows, see `signals`."""
        observe = OBSERVERS[self.task.observation]
        return self.act(observe(signals_of_estimate(estimate, desired)))


def SavePolicy(policy: Policy, path: str | Path) -> None:
    """Writes a policy as `.npz`; it appears complete or not at all."""
    arrays = {f"W{i}": W for i, W in enumerate(policy.weights)}
    arrays |= {f"b{i}": b for i, b in enumerate(policy.biases)}
    arrays |= {f"law_{k}": np.array(v) for k, v in asdict(policy.law).items()}
    text = yaml_dump_typed(policy.task)
    memory = io.BytesIO()
    np.savez(
        memory,
        format=np.array(FORMAT),
        mean=policy.mean,
        gain=policy.gain,
        clip=np.array(policy.clip),
        selected=policy.selected,
        task=np.array(text),
        **arrays,
    )
    WriteBytes(Path(path), memory.getvalue())


def LoadPolicy(path: str | Path) -> Policy:
    """Reads a policy that `SavePolicy` has written.

    Raises:
        PolicyError: The file cannot be read, or holds no such policy.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
    except OSError as error:
        raise PolicyError(f"{path}: cannot be read: {reason(error)}") from error
    # What zip files and their decoders raise on a broken one is not foreseen.
    except Exception as error:
        raise PolicyError(
            f"{path}: is not a policy (*.npz of `brace-drake train`)"
        ) from error
    found = arrays.get("format", np.array("none"))
    if found.ndim or found.tolist() != FORMAT:
        raise PolicyError(f"{path}: format {found}; allowed: {FORMAT}")
    layers = sum(1 for name in arrays if name[0] == "W" and name[1:].isdigit())
    try:
        law = {f.name: arrays[f"law_{f.name}"] for f in fields(ActionLaw)}
        policy = Policy(
            weights=tuple(arrays[f"W{i}"] for i in range(layers)),
            biases=tuple(arrays[f"b{i}"] for i in range(layers)),
            mean=arrays["mean"],
            gain=arrays["gain"],
            clip=float(arrays["clip"]),
            law=ActionLaw(
                **{k: v if v.ndim else v.item() for k, v in law.items()}
            ),
            selected=arrays["selected"],
            task=yaml_load_typed(schema=LearningTask, data=str(arrays["task"])),
        )
    except (KeyError, RuntimeError, ValueError, TypeError, YAMLError) as error:
        line = " ".join(str(error).split())
        raise PolicyError(f"{path}: not a policy: {line}") from error
    _check(policy, path)
    return policy


def _check(policy: Policy, path: str | Path) -> None:
    """Checks that layers fit each other, and that all numbers are finite."""
    size = len(policy.mean)
    for i, (W, b) in enumerate(zip(policy.weights, policy.biases, strict=True)):
        good = W.ndim == 2 and W.shape[1] == size and b.shape == W.shape[:1]
        if not good or not (np.isfinite(W).all() and np.isfinite(b).all()):
            raise PolicyError(
                f"{path}: layer {i} is {W.shape}, {b.shape}; allowed: finite"
                f" numbers, (m, {size}) and (m,)"
            )
        size = W.shape[0]
    if size != len(policy.law.start):
        raise PolicyError(
            f"{path}: the network has {size} outputs; allowed:"
            f" {len(policy.law.start)}, as there are stiffnesses"
        )


def ExportOnnx(policy: Policy, path: str | Path) -> None:
    """Writes the network with its scaling as ONNX: observation -> action.

    Bounds and rate limit of the stiffness stay outside, in `law`; they are
    among the model's metadata.

    Raises:
        PolicyError: The package onnx is not installed.
    """
    try:
        import onnx
        from onnx import TensorProto, helper, numpy_helper
    except ImportError as error:
        raise PolicyError(
            "ONNX needs one more package: pip install -e '.[onnx]'"
        ) from error
    named: dict[str, np.ndarray] = {
        "mean": policy.mean,
        "gain": policy.gain,
        "low": np.array(-policy.clip),
        "high": np.array(policy.clip),
    }
    nodes = [
        helper.make_node("Sub", ["observation", "mean"], ["centred"]),
        helper.make_node("Mul", ["centred", "gain"], ["scaled"]),
        helper.make_node("Clip", ["scaled", "low", "high"], ["cut"]),
        helper.make_node("Cast", ["cut"], ["x0"], to=TensorProto.FLOAT),
    ]
    last = len(policy.weights) - 1
    for i, (W, b) in enumerate(zip(policy.weights, policy.biases, strict=True)):
        named |= {f"W{i}": W, f"b{i}": b}
        out = "action" if i == last else f"x{i + 1}"
        nodes += [
            helper.make_node("Gemm", [f"x{i}", f"W{i}", f"b{i}"], [f"y{i}"],
                             transB=1),
            helper.make_node("Tanh" if i == last else "Relu", [f"y{i}"], [out]),
        ]  # fmt: skip
    graph = helper.make_graph(
        nodes,
        "rlpic",
        [_onnx_row("observation", TensorProto.DOUBLE, len(policy.mean))],
        [_onnx_row("action", TensorProto.FLOAT, len(policy.law.start))],
        [numpy_helper.from_array(a, name) for name, a in named.items()],
    )
    model = helper.make_model(
        graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9
    )
    law = {k: np.array(v).tolist() for k, v in asdict(policy.law).items()}
    helper.set_model_props(model, {k: str(v) for k, v in law.items()})
    onnx.checker.check_model(model)
    WriteBytes(Path(path), model.SerializeToString())


def _onnx_row(name: str, kind: int, size: int):
    from onnx import helper

    return helper.make_tensor_value_info(name, kind, ["batch", size])
