"""The numbers that decide a verdict, and those that steer the search for it.

Misfits are mean squares in units of the noise floor's; amplitudes are square
roots of mean squares. The first part decides, the second part only says which
fits are made and how far they are led.
"""

import math

# ---- Decision ---------------------------------------------------------------

# Misfit that means nothing where no effect takes it: the level of the
# instruments' noise is known to 5 %, its square to 10 %.
LEVEL = 0.10
# What a right twin is exact to: the misfit to which fits are compared, and the
# share that the laws of dry friction, which are forms, leave of the amplitude
# of what it does (0.6 % with 2 N in each leg).
TRUST = 0.01
# Weight of a difference of scores in the log odds of two explanations
# (tools/calibrate_probability.py).
ODDS = 2.5
# So many causes a machine may have, in the library or not. Of sets of as many
# effects each is as likely beforehand (`criterion.cost_of`): the first effect
# has to leave a quarter of what is left without it, a second one a third.
CAUSES = 32
# So many levels are more than a right twin leaves: what an effect would have to
# take before it pays.
BEYOND_LEVEL = CAUSES ** (1.0 / ODDS)
# Share of the gap's amplitude that is worth a word when nothing explains it.
MATERIAL = 0.20
# Explanations whose scores differ by less are tied: one leaves twice as much as
# the other. What a richer law of one effect has to leave less is the same.
TIED = math.log(2.0)
# Effects whose strength is within so many tolerances are no finding.
WITHIN = 3.0
# What is farther off costs the logarithm of its distance so many times: with
# `ODDS`, tolerances have the tails of Student's distribution with nine degrees
# of freedom.
TAIL = 4.0
# Any probability is so far from 1 and 0 at least.
UNSURE = 0.02
# ---- Search -----------------------------------------------------------------

# Sets of at most so many effects are made of so many best smaller ones, which
# leave at most this many times as much as the best.
MOST_EFFECTS, BEAM, NEAR = 3, 2, 4.0
# Larger sets are made where the best leaves at most this share of what is left
# with an effect less.
WORTH_A_SET = 2.0 / 3.0
# Friction within tolerance that changes less than this share of what is left
# explains nothing of it.
WORTH_FRICTION = 0.1
# Misfit that leaves nothing to search for.
TWIN_ERROR = 0.02
# About as near as a coarse search comes; over dozens of parameters the last of
# it is left to the end of the search. A prediction below noise by more than
# `COARSE_PREDICTION` is none.
COARSE, COARSE_OF_MANY, COARSE_PREDICTION = 0.01, 0.5, 0.03
# Screening: steps of a round; rounds, as long as one leaves less than this
# share of what the one before has left.
STEPS, ROUNDS, WORTH_A_ROUND = 5, 4, 0.7
# What the first round leaves at the very best.
BEST_ROUND = 0.1
# A round that leaves what was predicted, so near, has come to its end; a
# prediction of less than this share of what is left has failed.
AS_PREDICTED, FAILED = 0.02, 0.8
# Searched are so many candidates, and all predicted to leave at most this many
# times what the best leaves; fewer once one has come to the floor; beyond them
# those that take this share of the gap.
PLACES, FACTOR, PLACES_AT_FLOOR, WORTH_A_PLACE = 5, 2.0, 3, 0.1
# So many candidates are searched side by side.
AT_ONCE = 4
# A start that is predicted to leave this share of the gap is not tried again,
# and beyond so many places not searched; beside drives that stick, of whose
# chance any effect takes a part, already what leaves less.
HOPELESS, HOPELESS_ROUGH, HOPELESS_PLACES = 0.95, 0.8, 2
# Effects of dozens of parameters, of which a step was taken, are not searched
# where that is predicted to leave this share.
HOPELESS_OF_MANY = 0.98
# A start is tried at another strength, this often, where it is more than that
# many times too strong or too weak.
RESCALED, ENOUGH, WEAKEST = 2, 0.4, 0.05
# Starts of an effect that a quick screening takes, at most.
QUICK_STARTS = 4
# Of more parameters than these a straight way says nothing; it is followed
# this many times as far as the start.
STRAIGHT_PARAMETERS, REACH = 4, 30.0
# Beyond this many parameters a Jacobian is differenced once in a round.
FEW = 8
# Relative decrease that ends a round: less is chance where drives stick, and
# dear over dozens of parameters.
END, END_ROUGH = 1e-3, 1e-2
# Shortlist: a candidate leaves at most this many times what the best leaves,
# and takes at least a tenth of what there was; so many are led to their end.
SHORTLIST, GAINED, NUM_SHORTLIST = 1.5, 0.9, 3
# About as near as screening comes where it is compared.
SHORTLIST_TRUST = 0.03
# Tolerances are weighed anew, so often, beside what leaves this share along
# them.
REWEIGHED, QUIETER = 2, 0.5
# Other values of discrete parameters that are searched, and steps of each.
OTHER_CHOICES, CHOICE_STEPS = 2, 4
# A nested effect sets out at these shares of the special case's strength, its
# shapes at so many times their starts; it begins better than that share of
# what the special case leaves, which is at most so many times the best.
NESTED_SHARES, NESTED_SHAPES = (0.1, 0.4, 1.2), (0.5, 1.0, 2.0)
NESTED_BETTER, NESTED_NEAR = 0.9, 2.0
NESTED_STEPS, NESTED_ROUNDS, NESTED_WORTH = 4, 3, 0.8
# An effect is replaced by another from so many starts that begin best.
EXCHANGED_STARTS = 2
