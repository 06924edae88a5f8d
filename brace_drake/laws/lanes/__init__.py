"""A number of several copies of a machine at once, for the compiled laws.

The laws are written for one machine. Called with `Lanes` in place of floats,
the same source is compiled for as many copies as one instruction of the
processor takes: each copy has numbers of its own, and all take the same steps
in time. `kinds` has the arithmetic, `functions` what laws say instead of an
`if` that copies may answer differently, `arrays` how arrays of them are made.
"""
