"""Model selection: is there a gap, and which effects explain it.

`search` fits candidate explanations; `criterion` holds what each leaves and
takes; `decision` turns them into a verdict with a probability. A gap is what
the fitted nominal twin leaves beyond what noise would (`null_bootstrap`); an
explanation takes nearly all of it, more than its freedom alone would
(`surrogate_data`), with parameters that agree with their prior
(`identification.prior_check`). Every number that decides stands in
`thresholds`.
"""
