"""Parameter estimation: how well a twin can follow a recording.

A run is weighed by the noise floor (`noise_floor`, `prepare`), so that a sum
of squares of one per value is noise alone. `evaluation` replays runs and gives
weighted residuals; `problem` scales the parameters of subject and effects;
`least_squares` is the bounded Gauss-Newton search, `fits` leads a candidate to
its end, and `intervals` says how well its parameters are known. `campaign_fit`
is the fit of a subject alone, by a MathematicalProgram that sets out from the
paper's regression (`contact_start`, `nn_regression`).

Nothing here chooses between explanations: see `brace_drake.selection`.
"""
