"""PPO on stable-baselines3: only this package needs it, and torch."""
