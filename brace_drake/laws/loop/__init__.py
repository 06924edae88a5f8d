"""Laws put together: the step of a brace of n rings, and who takes it.

`forces` has all forces with the effects in between, `ticks` goes from tick to
tick, `rollout` closes the loop, of one brace or of several copies side by side.
"""
