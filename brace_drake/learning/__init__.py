"""Learning the desired impedance: RLPIC as gymnasium envs, PPO, policies.

An env is a task on one of two loops of the brace that do the same within
1e-8, compiled laws or the Drake diagram; what an episode is drawn from, what
a policy sees, and how a step is judged have a module each. `training` is PPO.

Importing this package registers `BraceDrake/RLPIC-v0` (the paper's: one stage,
7 observations, stiffness along y) and `BraceDrake/RLPIC-Full-v0` (three stages,
18 degrees of freedom, equations (7) to (10)).

    import gymnasium, brace_drake.learning
    env = gymnasium.make("BraceDrake/RLPIC-v0")
"""

import gymnasium

__all__ = ["ENV_ID", "FULL_ENV_ID"]

ENV_ID = "BraceDrake/RLPIC-v0"
FULL_ENV_ID = "BraceDrake/RLPIC-Full-v0"

for _id, _maker in ((ENV_ID, "RlpicEnv"), (FULL_ENV_ID, "make_full_env")):
    if _id not in gymnasium.registry:
        gymnasium.register(
            _id, entry_point=f"brace_drake.learning.env:{_maker}"
        )
