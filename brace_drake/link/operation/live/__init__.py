"""A device watched while it runs: what is kept, since when, why.

`cycles_kept` writes each cycle as a run of a campaign, `naming` looks for
causes in a process of its own, `observer` puts both beside the twin.
"""
