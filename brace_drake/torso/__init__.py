"""The torso: its surface, its solid, and its contact with the brace's pads.

`measures` and `scan` with `sections` both become a `loft`, a stack of
cross-sections; `grid` and `solid` fill it with tetrahedra, `pads` and `faces`
shape pads on it, `fitted` puts these together. `contact` adds it to a plant of
Drake; `personalize` makes and `folder` keeps all files of a patient. Drake is
slow to import, so modules are imported where they are needed.
"""
