"""Every number of a device, with unit and limits: a file, a dataclass, arrays.

A scenario says what is simulated. `brace.BraceScenario` is the brace, of which
one stage or more move; `brace.BenchScenario` is its stage 2 alone. Limits stand
at the fields (`fields`); what only makes sense together is in `check` and
`stability`. `load.LoadScenario` and `load.SaveScenario` read and write files;
the modules of numbers pack a scenario into what the laws take.
"""
