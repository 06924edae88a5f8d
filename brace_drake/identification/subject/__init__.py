"""The fit of a subject alone, without any effect.

`campaign_fit` is the whole of it, by a MathematicalProgram (`subject_fit`) that
sets out from the paper's regression (`contact_start`, `nn_regression`).
"""
