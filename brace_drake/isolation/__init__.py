"""Where a gap lies.

Each block is tested alone on its recorded inputs (`block_tests`). The gap is
shared out over blocks (`repair_shares`), channels, phases of the motion and
bands (`budget`), and what the best twin leaves is described by the motion that
it goes with (`residual_shapes`). `locate` puts it together, and `decision`
accuses the blocks: those of the effects named, those of the law of what is
left, and where there is neither the one that the tests suspect.
"""
