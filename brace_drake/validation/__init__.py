"""How far the gap shrinks, on runs that no fit has seen.

Nothing is estimated on a validation run, but for what every run has of its own.
`shrinkage` measures the gap before and after the repair, `prediction` what
rival causes leave there, `held_out` what they leave on fit runs left out in
turn; `causes` ranks the causes by it. `repaired` keeps the repaired twin.
"""
