"""The verdict on a bench whose numbers are known to tolerances: an experiment.

`diagnose` takes the bench's numbers as exact. Here every number that has a
tolerance is a nuisance parameter with a normal prior, marginalised in all fits
(`devices.tolerances`), one criterion of few numbers decides
(`criterion`, `thresholds`), and one forward and backward search follows it
(`search`). Its numbers were chosen on the stored fits on which
`tools/score_criterion.py` counts, so that count flatters it; it has not been
tried on cases of its own. It is slow where drives stick.
"""
