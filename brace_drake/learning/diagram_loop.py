"""The brace as a diagram that decisions go into and observations come from."""

from __future__ import annotations

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.laws.loop.brace_loop import read_task_state
from brace_drake.learning.actions import ActionLaw
from brace_drake.learning.episode import Episode
from brace_drake.learning.policy_systems import Observer, StiffnessHold
from brace_drake.learning.signals import Signals
from brace_drake.model.brace_station import BraceStation, MakeBraceStation
from brace_drake.model.systems.brace_controllers import MakeController
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_rings


def MakeCubic(
    start: np.ndarray, way: np.ndarray, duration: float
) -> PiecewisePolynomial:
    """The cubic motion (18n rows) of `laws.cubic` as a trajectory.

    Afterwards it rests, for a day.
    """
    end = start + way
    still = np.zeros(len(start))
    times = [0.0, duration, duration + 86400.0]
    X = PiecewisePolynomial.CubicHermite(
        times, np.column_stack([start, end, end]), np.tile(still, (3, 1)).T
    )
    rate = X.derivative(1)
    rows = X, rate, rate.derivative(1)
    matrices = [
        np.vstack([part.getPolynomialMatrix(i) for part in rows])
        for i in range(2)
    ]
    return PiecewisePolynomial(matrices, times)


def MakeHeldDraws(draws: np.ndarray, period: float) -> PiecewisePolynomial:
    """Draws (ticks, channels) as a trajectory, each held around its tick."""
    rows = np.vstack([draws, draws[-1:]])
    edges = (np.arange(len(rows)) - 0.5) * period
    return PiecewisePolynomial.ZeroOrderHold(edges, rows.T)


class DiagramLoop:
    """The closed loop of a scenario as `CompiledLoop` has it, simulated.

    The diagram has an input `action` (k,) and an output `observation`, or,
    with a `policy` that has the ports of `PolicySystem`, none of both.
    """

    def __init__(
        self,
        scenario: BraceScenario,
        law: ActionLaw,
        selected: np.ndarray,
        observation: str,
        times: tuple[float, float],
        episode: Episode,
        policy: LeafSystem | None = None,
    ):
        sample_time, self._motion_time = times
        self._period = 1.0 / scenario.control.rate
        self._noisy = len(episode.draws) > 0
        controller = MakeController(scenario.control, pack_rings(scenario))
        self.station = station = MakeBraceStation(
            scenario, controller, uses=episode.uses
        )
        self._selected, self.uses = selected, episode.uses
        builder = DiagramBuilder()
        inner = builder.AddNamedSystem("station", station.diagram)
        hold = policy or StiffnessHold(law, selected, sample_time)
        hold = builder.AddNamedSystem("stiffness", hold)
        self._desired = builder.AddNamedSystem(
            "desired", TrajectorySource(self._MakeMotion(episode))
        )
        observer = hold
        if policy is None:
            observer = builder.AddNamedSystem(
                "observer", Observer(observation, len(selected))
            )
            builder.ExportInput(hold.GetInputPort("action"), "action")
            builder.ExportOutput(observer.get_output_port(), "observation")
        for source, port in (
            (self._desired.get_output_port(), inner.GetInputPort("desired")),
            (self._desired.get_output_port(), observer.GetInputPort("desired")),
            (
                inner.GetOutputPort("estimate"),
                observer.GetInputPort("estimate"),
            ),
            (hold.GetOutputPort("stiffness"), inner.GetInputPort("stiffness")),
        ):
            builder.Connect(source, port)
        if self._noisy:
            draws = MakeHeldDraws(episode.draws, self._period)
            self._draws = builder.AddNamedSystem(
                "draws", TrajectorySource(draws)
            )
            builder.Connect(
                self._draws.get_output_port(), inner.GetInputPort("noise")
            )
        self.diagram: Diagram = builder.Build()
        self.diagram.set_name("learning_loop")
        self.simulator = Simulator(self.diagram)
        self._FindParts(station)
        self.SetEpisode(episode)

    def _FindParts(self, station: BraceStation) -> None:
        forces = station.diagram.GetSubsystemByName("forces")
        self._law = station.diagram.GetSubsystemByName("force_law")
        self._plant: MultibodyPlant = station.plant
        self._torso = self._plant.GetBodyByName("torso")
        root = self.simulator.get_mutable_context()
        own = {
            system: system.GetMyMutableContextFromRoot(root)
            for system in (
                station.diagram, forces, self._law, self._plant, self._desired
            )
        }  # fmt: skip
        # Kept, as a callback finds its context's Python object faster then.
        self._kept = [
            system.GetMyContextFromRoot(root)
            for system in station.diagram.GetSystems()
        ]
        self._own = own
        outputs = {
            name: station.diagram.GetOutputPort(name)
            for name in ("plant_state", "estimate", "impedance")
        }
        self._outputs = {
            name: (port, own[station.diagram]) for name, port in outputs.items()
        }
        measured = forces.GetOutputPort("measured")
        self._outputs["measured"] = (measured, own[forces])
        desired = self._desired.get_output_port()
        self._outputs["desired"] = (desired, own[self._desired])
        self._rest = np.ascontiguousarray(station.numbers.geometry.rest)
        self._X = np.empty((2, len(self._selected)))

    def _MakeMotion(self, episode: Episode) -> PiecewisePolynomial:
        start = self.station.numbers.start
        return MakeCubic(start, episode.way, self._motion_time)

    def SetEpisode(self, episode: Episode) -> None:
        """Sets default context and parameters; its effects are as built."""
        root = self.simulator.get_mutable_context()
        root.SetTime(0.0)
        self.diagram.SetDefaultContext(root)
        self._desired.UpdateTrajectory(self._MakeMotion(episode))
        if self._noisy:
            draws = MakeHeldDraws(episode.draws, self._period)
            self._draws.UpdateTrajectory(draws)
        law = self._law.get_mutable_source_value(self._own[self._law])
        law.SetFromVector(episode.force_law)
        mass, moments = episode.torso[0], episode.torso[1:4] / episode.torso[0]
        inertia = SpatialInertia(mass, np.zeros(3), UnitInertia(*moments))
        self._torso.SetSpatialInertiaInBodyFrame(
            self._own[self._plant], inertia
        )

    def Eval(self, name: str) -> np.ndarray:
        """`plant_state`, `estimate`, `impedance`, `measured` or `desired`."""
        port, context = self._outputs[name]
        return port.Eval(context)

    @property
    def stiffness(self) -> np.ndarray:
        """K_d in use (6n,)."""
        return self.Eval("impedance")[2 * len(self._selected) :]

    def truth(self) -> Signals:
        """What is, whatever the instruments read."""
        m = len(self._selected)
        n = m // 6
        read_task_state(self.Eval("plant_state"), self._rest, self._X)
        desired, force = self.Eval("desired"), np.zeros((n, 6))
        force[:, 0:3] = -self.Eval("measured")[m : m + 3 * n].reshape(n, 3)
        return Signals(
            desired[0:m].copy(),
            desired[m : 2 * m].copy(),
            self._X[0].copy(),
            self._X[1].copy(),
            force.ravel(),
        )
