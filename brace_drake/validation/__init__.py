"""What runs that no fit has seen say of the verdict.

Nothing is estimated on a validation run, but for what every run has of its own
(`run_parameters`). What explanations leave there enters their scores
(`new_runs`). `confirm` has the last word: it leaves out copies of fit runs and
withdraws what the others contradict. `shrinkage` measures the gap
before and after the repair, `support` what each effect closes by itself,
`prediction` what rival causes leave; `causes` ranks the causes by the
criterion. `repaired` keeps the repaired twin.
"""
