"""The numbers that decide, and those that steer the search.

Misfits are mean squares in units of the noise floor's; amplitudes are square
roots of mean squares. The first part decides, the second part only says which
fits are made and how far they are led.
"""

import math

# ---- Decision ---------------------------------------------------------------

# Misfit that is trusted to mean nothing: the level of the instruments' noise is
# known to 5 %, its square to 10 %.
LEVEL = 0.10
# Laws of dry friction are forms: of the amplitude of what friction does that is
# known to be there this share is left.
FRICTION_ERROR = 0.25
# An effect has to leave a quarter of what is left without it, in logarithms.
COST_OF_EFFECT = math.log(4.0)
# So many levels are more than a right twin leaves. Chosen on the stored fits,
# whose held-out errors were made with no weight on what is left out: with 3
# levels five clean benches among them are called gaps.
BEYOND_LEVEL = 4.0
# Share of the gap's amplitude that is worth a word when nothing explains it.
MATERIAL = 0.20
# Explanations whose scores differ by less are tied: one leaves 1.5 times as
# much as the other.
TIED = math.log(1.5)
# Weight of a difference of scores in the log odds of two explanations
# (not calibrated yet).
ODDS = 2.0
# Effects whose strength is within so many tolerances are no finding.
WITHIN = 3.0

# ---- Search -----------------------------------------------------------------

# Sets of at most so many effects are made of so many best smaller ones, which
# leave at most this many times as much as the best.
MOST_EFFECTS, BEAM, NEAR = 2, 3, 4.0
# Effects that tolerances suggest, the farthest first.
MOST_STRETCHED = 4
# Weight that a motion left out keeps.
KEPT = 0.1
