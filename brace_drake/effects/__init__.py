"""The library of effects: one card, one file."""
