"""What other programs write, as arrays by name: one reader for each format.

A reader takes a path and a group, and raises a `ReadError` of one line. Those
that stand on a library which a hostile file may take down run in a process of
their own, see `apart`.
"""
