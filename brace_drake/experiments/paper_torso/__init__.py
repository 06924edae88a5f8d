"""The paper's Table 1 and its Figures 8 to 13 on a torso that leans on a pad.

`lean` fits what the paper does not say of its torso, `pushes` runs the table,
`reach` says what no number of the torso can give, `write` writes it down.
"""
