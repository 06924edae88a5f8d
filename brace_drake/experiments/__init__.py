"""The paper's experiments, and what policies and repairs are worth.

`compare` runs all controllers on one push, `evaluate` puts policies beside them
on many subjects, `validate` a recording beside its twin, and `transfer` asks
what a repaired twin is worth to a policy. `scores` says what is measured of a
push and `tables` how it is written down, for all of them.
"""
