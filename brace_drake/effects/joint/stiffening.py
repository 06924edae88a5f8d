"""A spring that is no straight line."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: position)
    for k in range(f.shape[0]):
        f[k] -= l[k] * l[k] * (p[0] + p[1] * l[k])


CARD = Effect(
    name="stiffening",
    block="mechanism",
    title="a spring that stiffens or softens",
    equation="F = k y + k_2 y^2 + k_3 y^3",
    source="Kovacic and Brennan, The Duffing Equation, 2011, section 1.2",
    parameters=(
        EffectParameter(
            "quadratic_N_m2",
            "N/m^2",
            -1e7,
            1e7,
            (2e4,),
            "k_2, different on both sides",
        ),
        EffectParameter(
            "cubic_N_m3", "N/m^3", -1e9, 1e9, (2e6,), "k_3, alike on both sides"
        ),
    ),
    laws={"drive": _law},
    needs=("one joint", "joint position"),
    signature="a force that bends over position, the same both ways",
    impostors={"relaxing_spring": "depends on how long it is held"},
    remedy="look for a stop or a cable that tightens near the end of the"
    " travel",
    experiment="slow strokes of two lengths",
)
