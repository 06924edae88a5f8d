"""Model selection: is there a gap, which effects are certain, what is left.

`search` fits explanations, sets of none to three effects; `criterion` scores
each by what it leaves, on its own runs and on motions left out of it, and by
what its effects cost; `decision` turns the scores into a verdict with
probabilities. `tolerated` knows what is within tolerances and so no finding,
`level` what even a right twin leaves, and `settle` ends the search. Every
number that decides stands in `thresholds`.
"""
