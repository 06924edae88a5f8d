"""Motions that a device may be asked for.

`reference` interpolates and reads references of n rings, `times` says how long
and how fine a file may be; `library` has the bench's motions by name; `limits`
decides what a device may be asked for, of the bench by its limits, of a drive
or a pad by how far its recordings reached (`recorded_reach`). `parts` are
ramps, stairs and sines with derivatives.
"""
