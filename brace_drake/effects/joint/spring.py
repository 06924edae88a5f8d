"""A spring at a joint that the nominal model does not have."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: position)
    for k in range(f.shape[0]):
        f[k] -= p[0] * l[k] + p[1]


CARD = Effect(
    name="joint_spring",
    block="mechanism",
    title="a spring at the joint",
    equation="F = k y + F_0",
    source="Craig, Introduction to Robotics, section 6.5",
    parameters=(
        EffectParameter(
            "stiffness_N_m", "N/m", -6000.0, 6000.0, (100.0,), "stiffness k"
        ),
        EffectParameter("force_N", "N", -60.0, 60.0, (0.5,), "force at 0, F_0"),
    ),
    laws={"drive": _law},
    needs=("joint of a plant",),
    signature="a force in proportion to the place, the same both ways",
    impostors={"unbalanced_weight": "a force that follows the angle's sine"},
    remedy="look for a cable, a hose or a seal that pulls back",
    experiment="slow strokes over the whole way",
)
