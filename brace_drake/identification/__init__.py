"""Parameter estimation: how well a twin can follow a recording.

A run is weighed by the noise floor (`noise_floor`, `prepare`), so that a sum
of squares of one per value is noise alone. `evaluation` replays runs and gives
weighted residuals; `problem` scales the parameters of subject and effects;
`least_squares` is the bounded Gauss-Newton search, `fits` leads a candidate to
its end, and `intervals` says how well its parameters are known. `nominal_fit`
fits the subject with numbers within their tolerances, and `held_out` says what
a fit leaves on motions that it has not seen. `subject` fits a subject alone.

Nothing here chooses between explanations: see `brace_drake.selection`.
"""
