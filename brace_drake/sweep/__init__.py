"""A twin over one number of its scenario: what changes, and by how much.

`numbers` finds a number by its path and sets it within its limits, `runs`
simulates the twin with each value, `outcomes` says what is told of a run.
`sweep` does it for all values and seeds, `page` writes it down.
"""
