"""Energy of a run of the brace, from its states alone.

Work and losses are sums over steps of forces times differences of lengths,
compressions and positions, so that neither a Jacobian nor a force of the
plant is in them.
"""

import numpy as np
from scipy.spatial.transform import Rotation


class EnergyBook:
    """Takes down a run as its monitor, then settles the account.

    `stored` is kinetic energy, weight, posture and pads; `work` that of the
    commands; `lost` what legs, posture and pads have taken.
    """

    def __init__(self, station, scenario):
        self.station, self.scenario = station, scenario
        self.rows = []
        self.commands = station.diagram.GetOutputPort("drive_force")
        self.lengths = station.diagram.GetOutputPort("leg_length")

    def __call__(self, context):
        plant = self.station.plant
        own = plant.GetMyContextFromRoot(context)
        mechanical = plant.CalcKineticEnergy(own)
        mechanical += plant.CalcPotentialEnergy(own)
        bodies = [*self.scenario.rings]
        if self.scenario.torso.present:
            bodies.append("torso")
        poses = []
        for name in bodies:
            X_WB = plant.EvalBodyPoseInWorld(own, plant.GetBodyByName(name))
            poses.append(
                np.append(X_WB.rotation().matrix(), X_WB.translation())
            )
        self.rows.append(
            (
                mechanical,
                self.commands.Eval(context).copy(),
                self.lengths.Eval(context).copy(),
                np.array(poses),
            )
        )

    def settle(self, dt):
        """Change of stored energy, work of the commands, losses, J."""
        mechanical = np.array([r[0] for r in self.rows])
        u = np.array([r[1] for r in self.rows])
        lengths = np.array([r[2] for r in self.rows])
        poses = np.array([r[3] for r in self.rows])
        steps = np.diff(lengths, axis=0)
        # The command in force from a step to the next.
        work = (u[:-1] * steps).sum()
        viscous = self.scenario.leg.viscous
        lost = viscous * (steps**2).sum() / dt
        stored = mechanical
        if self.scenario.torso.present:
            spring, loss = self._posture(poses[:, -1], dt)
            stored, lost = stored + spring, lost + loss
            for i, contact in enumerate(self.scenario.contacts):
                if contact.model == "linear":
                    for s in (1.0, -1.0):
                        spring, loss = _pad(
                            poses[:, i], poses[:, -1], contact, s, dt
                        )
                        stored, lost = stored + spring, lost + loss
        return stored[-1] - stored[0], work, lost

    def _posture(self, pose, dt):
        torso = self.scenario.torso
        p = pose[:, 9:12] - [0, 0, self.scenario.ring_heights[2]]
        r = Rotation.from_matrix(pose[:, 0:9].reshape(-1, 3, 3)).as_rotvec()
        spring = 0.5 * (torso.posture_stiffness * p**2).sum(axis=1)
        spring += 0.5 * (torso.posture_rot_stiffness * r**2).sum(axis=1)
        v, w = np.diff(p, axis=0) / dt, np.diff(r, axis=0) / dt
        loss = (torso.posture_damping * v**2).sum() * dt
        loss += (torso.posture_rot_damping * w**2).sum() * dt
        return spring, loss


def _pad(ring, torso, contact, s, dt):
    """Energy in a pad's spring at each step, and what its damper and friction
    have taken; s = +1 at +y."""
    R_R, R_T = (a[:, 0:9].reshape(-1, 3, 3) for a in (ring, torso))
    p = ring[:, 9:12] + s * contact.pad_offset * R_R[:, :, 1] - torso[:, 9:12]
    # The pad's centre in the torso's frame.
    at = np.einsum("tji,tj->ti", R_T, p)
    d = contact.preload + contact.pad_offset - s * at[:, 1]
    spring = 0.5 * contact.stiffness * np.maximum(d, 0.0) ** 2
    rate = np.diff(d) / dt
    force = contact.stiffness * d[:-1] + contact.damping * rate
    N = np.where((d[:-1] > 0.0) & (force > 0.0), force, 0.0)
    loss = (N * np.diff(d)).sum() - (spring[-1] - spring[0])
    slide = np.linalg.norm(np.diff(at[:, [0, 2]], axis=0), axis=1) / dt
    drag = contact.friction * N
    drag = drag * np.tanh(slide / contact.friction_regularization)
    return spring, loss + (drag * slide).sum() * dt
