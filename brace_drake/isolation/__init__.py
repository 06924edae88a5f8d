"""Where a gap lies.

Each block is tested alone on its recorded inputs (`block_tests`), contact and
torso on the recorded way of the brace (`imposed_motion`), and drives, ring and
reading by the balance of forces (`force_balance`). The gap is shared out over
blocks (`repair_shares`, `attribution`), channels, phases of the motion and
bands (`budget`), and what the best twin leaves is described by the motion that
it goes with (`residual_shapes`). `locate` puts it together, and `decision`
accuses the blocks: those of the effects named and, where none is, the one in
which what is left lies.
"""
