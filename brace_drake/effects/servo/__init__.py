"""Limits of a machine that is commanded a speed or a position."""
