"""The numbers that decide a verdict and steer the search for it.

Misfits and gains are mean squares in units of the noise floor's; amplitudes
are square roots of mean squares. The first part decides, the second part only
says which fits are made and how far they are led.
"""

# ---- Decision ---------------------------------------------------------------

# The level of the instruments' noise is trusted to 5 %, its square to 10 %: a
# repeat of one run shows no less.
NOISE_LEVEL = 0.10
# Mean square up to which a twin of the right effect is trusted to follow a
# recording: a tenth of the floor's amplitude and a bit. Where no average over
# noise is taken the twin's own errors are smaller.
TWIN_ERROR, TWIN_ERROR_EXACT = 0.02, 0.005
# Gain that an effect may owe to errors of the twin: for each parameter, and at
# the least and the most.
GAIN_PER_PARAMETER, LEAST_GAIN, MOST_GAIN = 0.005, 0.015, 0.03
# Simulated fault-free campaigns: noise replicates of each run, campaigns drawn
# from them, and the quantile that counts as more than noise.
NULL_REPLICATES, NULL_DRAWS, NULL_QUANTILE = 6, 400, 0.99
# Effects of more parameters have priors that keep them from chance.
NULL_PARAMETERS = 8
# Share of the gap's amplitude that an explanation takes away: more where
# instruments and nominal numbers are given, so that only the law of the effect
# may differ; less where a device is known by its recording alone.
SHARE_KNOWN, SHARE_REAL = 0.80, 0.75
# The same for two effects together, where they leave more than the noise: no
# law is exact to a hundredth of what it does, nor any twin to a tenth where
# drives stick.
PAIR_SHARE, PAIR_SHARE_STICKING = 0.99, 0.90
# Mean square up to which a repaired twin counts as good: what is left is not
# more than the noise. Where drives stick replays come to no floor.
NEAR_FLOOR, NEAR_FLOOR_STICKING = 1.0, 0.5
# Share of the gap's amplitude that a flexible effect closes, and an effect
# beside which a second one is sought.
HALF = 0.5
# Two effects leave this share of what one leaves.
SECOND_PAYS = 0.25
# A fit of fewer parameters is preferred up to this many times what is left.
SIMPLER = 2.0
# Rivals that leave less than this many times the winner's rest are tied.
TIED = 1.5
# A threshold of misfit that campaigns recorded in full stay below.
WHOLE_THRESHOLD = 0.125
# Surrogate data: none of so many may take as much of the gap; one that does so
# much of what the effect does is a copy of it and tells nothing.
NUM_SURROGATES, SURROGATE_COPY = 99, 0.5
# Log-odds of being right over those stated, as withheld cases showed them
# (tools/calibrate_probability.py), and the limits of any probability.
ODDS_OFFSET, ODDS_SLOPE = 0.20, 0.91
LEAST_PROBABILITY, MOST_PROBABILITY = 0.02, 0.98

# ---- Search -----------------------------------------------------------------

# Screening leaves this many times what the end of a search leaves, or less;
# the coarse plant step may add this share of the gap.
UNFINISHED, UNFINISHED_SHARE = 2.0, 0.25
# About as near as a coarse search comes; over dozens of parameters the last of
# it is left to the end of the search. A prediction below noise by more than
# `COARSE_PREDICTION` is none.
COARSE, COARSE_OF_MANY, COARSE_PREDICTION = 0.01, 0.5, 0.03
# Screening: steps of a round; rounds, as long as one leaves less than this
# share of what the one before has left.
STEPS, ROUNDS, WORTH_A_ROUND = 5, 4, 0.7
# What a round leaves where it goes well, and the first one at the very best.
GOOD_ROUND, BEST_ROUND = 0.5, 0.1
# A round that leaves what was predicted, so near, has come to its end; a
# prediction of less than this share of what is left has failed.
AS_PREDICTED, FAILED = 0.02, 0.5
# Searched are so many candidates, and all predicted to leave at most this many
# times what the best leaves; fewer once one has come to the floor; beyond them
# those that take this share of the gap.
PLACES, FACTOR, PLACES_AT_FLOOR, WORTH_A_PLACE = 5, 2.0, 3, 0.1
# A start that is predicted to leave this share of the gap is not tried again,
# and beyond so many places not searched.
HOPELESS, HOPELESS_PLACES = 0.98, 2
# A start is tried at another strength, this often, where it is more than that
# many times too strong or too weak.
RESCALED, ENOUGH, WEAKEST = 2, 0.4, 0.05
# A straight way predicts half of what a search takes, or less; of more
# parameters than these it says nothing; it is followed this many times as far
# as the start.
BENDS, STRAIGHT_PARAMETERS, REACH = 2.0, 4, 30.0
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
# Other values of discrete parameters that are searched, and steps of each.
OTHER_CHOICES, CHOICE_STEPS = 2, 4
# A nested effect sets out at these shares of the special case's strength, its
# shapes at so many times their starts; it begins better than that share of
# what the special case leaves, which is at most so many times the best.
NESTED_SHARES, NESTED_SHAPES = (0.1, 0.4), (0.5, 1.0, 2.0)
NESTED_BETTER, NESTED_NEAR = 0.9, 2.0
NESTED_STEPS, NESTED_ROUNDS, NESTED_WORTH = 4, 3, 0.8
# Excess of a second effect, of what one leaves, that makes it worth a search,
# and of a round of a pair's search, of what the one before has left.
WORTH_A_SECOND, WORTH_A_PAIR_ROUND = 0.5, 0.5
# Pairs: searched of all that are predicted; set out afresh, in so many rounds
# of so many steps at these strengths, as long as each halves what is left.
NUM_PAIRS, PAIRS_AFRESH = 4, 2
AFRESH_ROUNDS, AFRESH_STEPS, STRENGTHS = 3, 4, (1.0, 0.5)
# Steps from a pair to one of its effects.
WITHOUT_ONE_STEPS = 4
# Replays of all runs after which no other search for pairs begins.
MOST_REPLAYS = 500
# Small second effects that are searched, and steps of each.
SMALL_PLACES = 3
# Searches that begin again: so far in parts of the subject's parameters and of
# the effects'; so often; until one leaves less than half.
RESTART_SUBJECT, RESTART_EFFECTS, RESTARTS, ESCAPED = 0.2, 0.02, 3, 0.5
# What a second effect is predicted to leave beside parameters that are no
# sample of their prior; others predicted to leave so many times as much take
# its place.
JOINT_PREDICTED, JOINT_RIVAL = 0.5, 1.5
# Frictions that are refitted beside what imposed motion shows; of those that
# leave at most so many times the least; with what they leave of what the
# effect leaves without them; steps of the search, first and last, and the
# relative decrease that ends it.
NUM_FRICTIONS, FRICTION_NEAR, FRICTION_SHARE = 2, 2.0, 0.25
FRICTION_STEPS, FRICTION_LAST_STEPS, FRICTION_END = 8, 3, 1e-2
