"""The search for explanations: which candidate fits are made.

`search.search_causes` is the whole of it: screening of every effect by one
linearised replay (`linearisation`, `screening`), a shortlist led to its end
(`shortlist`), richer and simpler forms (`nested`), and second effects where no
single one explains the gap (`forward`, `pairs`). What is chosen among the fits
is decided in `brace_drake.selection.decision`.
"""
