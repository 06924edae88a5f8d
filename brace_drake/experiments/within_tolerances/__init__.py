"""The verdict on a bench whose numbers are known to tolerances: an experiment.

`diagnose` takes the bench's numbers as exact. Here every number that has a
tolerance is a nuisance parameter with a normal prior, marginalised in all fits
(`devices.tolerances`), one criterion of few numbers decides
(`criterion`, `thresholds`), and one forward and backward search follows it
(`search`). On stored fits of 104 clean blind cases that criterion is as good
as the default decision (`tools/score_criterion.py`); on benches within their
tolerances it names what the default cannot. It is slow where drives stick.
"""
