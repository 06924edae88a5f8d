"""The brace between two decisions, as its Drake diagram."""

from __future__ import annotations

import numpy as np
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.effects.stack import modify_numbers
from brace_drake.learning.episode import Episode
from brace_drake.learning.signals import Signals, calc_task_state, true_signals
from brace_drake.model.brace_station import MakeBraceStation
from brace_drake.model.systems.brace_controllers import MakeController
from brace_drake.model.systems.ticks import TICK_LEAD
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

    Attributes:
        simulator, diagram: Of the episode; its effects are built in.
    """

    def __init__(
        self, scenario: BraceScenario, sample_time: float, motion_time: float
    ):
        self._scenario = scenario
        self._sample_time, self._motion_time = sample_time, motion_time
        self.diagram: Diagram | None = None
        self.simulator: Simulator | None = None

    def start(self, episode: Episode, stiffness: np.ndarray) -> None:
        """Sets everything to time 0 and performs the first tick."""
        if self.diagram is None or episode.uses:
            self._Build(episode)
        root = self.simulator.get_mutable_context()
        root.SetTime(0.0)
        self.diagram.SetDefaultContext(root)
        for name, trajectory in self._MakeInputs(episode).items():
            self.diagram.GetSubsystemByName(name).UpdateTrajectory(trajectory)
        law = self._station.GetSubsystemByName("force_law")
        context = law.GetMyMutableContextFromRoot(root)
        numbers = modify_numbers(episode.numbers, episode.uses)
        law.get_mutable_source_value(context).SetFromVector(numbers.force_law)
        mass, moments = numbers.torso[0], numbers.torso[1:4] / numbers.torso[0]
        inertia = SpatialInertia(mass, np.zeros(3), UnitInertia(*moments))
        self._plant.GetBodyByName("torso").SetSpatialInertiaInBodyFrame(
            self._plant.GetMyMutableContextFromRoot(root), inertia
        )
        self._step = 0
        self._Ask(stiffness)
        self.simulator.Initialize()

    def advance(self, stiffness: np.ndarray) -> None:
        """Goes on to the next decision with a stiffness (6n,) asked for.

        Raises:
            RuntimeError: The simulation broke down.
        """
        self._Ask(stiffness)
        self._step += 1
        # After the tick of that time, before the plant moves on. Sums of steps
        # would drift across events.
        end = self._step * self._sample_time
        self.simulator.AdvanceTo(end - 0.5 * TICK_LEAD)

    def _Ask(self, stiffness: np.ndarray) -> None:
        port = self.diagram.GetInputPort("stiffness")
        port.FixValue(self.simulator.get_mutable_context(), stiffness)

    def _MakeInputs(self, episode: Episode) -> dict[str, PiecewisePolynomial]:
        """Trajectories of the station's inputs by the inputs' names."""
        motion = MakeCubic(self._start, episode.way, self._motion_time)
        if not len(episode.draws):
            return {"desired": motion}
        period = 1.0 / self._scenario.control.rate
        noise = MakeHeldDraws(episode.draws, period)
        return {"desired": motion, "noise": noise}

    def _Build(self, episode: Episode) -> None:
        scenario = self._scenario
        controller = MakeController(scenario.control, pack_rings(scenario))
        station = MakeBraceStation(scenario, controller, uses=episode.uses)
        self._station, self._plant = station.diagram, station.plant
        self._start = station.numbers.start
        self._rest = station.numbers.rest
        builder = DiagramBuilder()
        inner = builder.AddNamedSystem("station", station.diagram)
        for name, trajectory in self._MakeInputs(episode).items():
            source = builder.AddNamedSystem(name, TrajectorySource(trajectory))
            builder.Connect(source.get_output_port(), inner.GetInputPort(name))
        builder.ExportInput(inner.GetInputPort("stiffness"), "stiffness")
        self.diagram = builder.Build()
        self.diagram.set_name("learning_loop")
        self.simulator = Simulator(self.diagram)
        root = self.simulator.get_context()
        forces = inner.GetSubsystemByName("forces")
        desired = self.diagram.GetSubsystemByName("desired")
        ports = {
            name: (
                system.GetOutputPort(port),
                system.GetMyContextFromRoot(root),
            )
            for name, system, port in (
                ("plant_state", inner, "plant_state"),
                ("estimate", inner, "estimate"),
                ("impedance", inner, "impedance"),
                ("pad_force", forces, "measured"),
                ("desired", desired, desired.get_output_port().get_name()),
            )
        }
        self._ports = ports
        # A callback finds its context's Python object faster where it is kept.
        self._kept = [s.GetMyContextFromRoot(root) for s in inner.GetSystems()]

    def _Eval(self, name: str) -> np.ndarray:
        port, context = self._ports[name]
        return port.Eval(context)

    @property
    def desired(self) -> np.ndarray:
        """X_d, X_d', X_d'' (18n,) now."""
        return self._Eval("desired")

    @property
    def estimate(self) -> np.ndarray:
        """X, X', filtered force on the torso (18n,) as the controller knows."""
        return self._Eval("estimate")

    @property
    def stiffness(self) -> np.ndarray:
        """K_d in use (6n,)."""
        return self._Eval("impedance")[-self._rest.size * 2 :]

    def truth(self) -> Signals:
        """What is, whatever the instruments read."""
        n = len(self._rest)
        X = calc_task_state(self._Eval("plant_state"), self._rest)
        pads = self._Eval("pad_force")[6 * n : 9 * n]
        return true_signals(self.desired, X, pads)
