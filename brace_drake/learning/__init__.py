"""Learning the desired impedance: RLPIC as gymnasium envs, PPO, policies.

A `task` holds every number; `episode` draws a subject, a motion and noise for
it. `env` runs an episode on one of two loops that do the same within 1e-8,
compiled laws or the Drake diagram; `signals` says what a policy sees, `actions`
what it may ask for, `rewards` how a step is judged. `training` is PPO, `policy`
the file that comes of it, `predict` and `deployment` put it to use.

Importing this package registers `BraceDrake/RLPIC-v0` (the paper's: one stage,
7 observations, stiffness along y) and `BraceDrake/RLPIC-Full-v0` (three stages,
18 degrees of freedom, equations (7) to (10)).

    import gymnasium, brace_drake.learning
    env = gymnasium.make("BraceDrake/RLPIC-v0")
    envs = gymnasium.make_vec("BraceDrake/RLPIC-v0", num_envs=8)

`vector` steps many episodes at once, each what it is alone.
"""

import importlib

import gymnasium

ENV_ID = "BraceDrake/RLPIC-v0"
FULL_ENV_ID = "BraceDrake/RLPIC-Full-v0"

for _id, _maker, _vector in (
    (ENV_ID, "RlpicEnv", "make_vector_env"),
    (FULL_ENV_ID, "make_full_env", "make_full_vector_env"),
):
    if _id not in gymnasium.registry:
        gymnasium.register(
            _id,
            entry_point=f"brace_drake.learning.env:{_maker}",
            vector_entry_point=f"brace_drake.learning.vector.env:{_vector}",
        )

# Where the public names are; Drake and Numba are slow to import.
_MODULES = {
    "LearningTask": "task",
    "LoadPolicy": "policy",
    "Policy": "policy",
    "PolicySystem": "deployment",
    "RlpicEnv": "env",
    "RlpicVectorEnv": "vector.env",
    "SavePolicy": "policy",
    "predict_impedance": "predict",
    "run_episode": "episode",
}
__all__ = ["ENV_ID", "FULL_ENV_ID", *_MODULES]


def __getattr__(name: str):
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = importlib.import_module(f"{__name__}.{_MODULES[name]}")
    return getattr(module, name)
