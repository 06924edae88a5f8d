"""PPO with the paper's hyper-parameters, on stable-baselines3 and torch.

`train` starts runs and continues them, `learner` is PPO between two updates
and its state, `actor_critic` the paper's networks, `numbers` the
hyper-parameters, `run_folder` what a run has on disk.
"""
