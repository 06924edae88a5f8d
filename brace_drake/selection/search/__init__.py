"""The search for explanations: which candidate fits are made.

`search.search_causes` is the whole of it, forward and backward over sets of
effects: every effect beside the best smaller sets is screened by one linearised
replay (`linearisation`, `screening`), the best are fitted (`candidate`) and led
to their end (`shortlist`), richer forms set out from simpler ones (`nested`),
numbers that are stretched beyond their tolerances suggest effects
(`stretched`), and of each set every effect is left out again. It ends where
what is left is no more than a right twin leaves, or where one more effect is no
better. What is chosen among the fits is decided in
`brace_drake.selection.decision`.
"""
