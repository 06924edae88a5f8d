"""A trained policy on numpy alone: its network, scaling, bounds, and task."""

from __future__ import annotations

import io
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from pydrake.common.yaml import yaml_dump_typed

from brace_drake.core.errors import PolicyError
from brace_drake.core.output import WriteBytes
from brace_drake.learning.actions import ActionLaw
from brace_drake.learning.policy_file import FORMAT, PolicyFile
from brace_drake.learning.signals import OBSERVERS, signals_of_estimate
from brace_drake.learning.task import LearningTask


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
    file = PolicyFile(path)
    selected = file.take_selected()
    task = file.take_task(len(selected))
    inputs = file.size_of_observation(task, len(selected))
    outputs = int(selected.sum())
    weights, biases = file.take_layers(inputs, outputs)
    return Policy(
        weights=weights,
        biases=biases,
        mean=file.numbers("mean", (inputs,)),
        gain=file.numbers("gain", (inputs,)),
        clip=file.number("clip", 1e-9),
        law=file.take_law(outputs),
        selected=selected,
        task=task,
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
