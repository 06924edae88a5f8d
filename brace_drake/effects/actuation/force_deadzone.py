"""A drive that gives nothing to small commands."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import delivered, plug


@plug("drive", lanes=True)
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    for k in range(f.shape[0]):
        arrives = delivered(f, law, l_dot, k)
        f[k] -= min(max(arrives, -p[0]), p[0])


CARD = Effect(
    name="force_deadzone",
    block="actuation",
    title="dead zone of the drives around zero command",
    equation="f = u - sat(u, +-w) - b l': none inside +-w, less by w outside",
    source="Tao and Kokotovic, Adaptive Control of Systems with Actuator and"
    " Sensor Nonlinearities, 1996, chapter 2",
    parameters=(
        EffectParameter(
            "deadzone_N", "N", 0.0, 30.0, (0.3,), "half width w of the zone"
        ),
    ),
    laws={"drive": _law},
    on_command=True,
    dithered=True,
    signature="commands larger by a constant away from zero, steep through it",
    impostors={
        "coulomb_friction": "follows the sign of the speed, not of the command",
        "weak_leg": "one leg only, in proportion to its command",
    },
    remedy="read a drive's force over small commands; take the dead zone out"
    " of its amplifier, or add it to the command",
    experiment="stairs, held: no speed, commands of both signs",
)
