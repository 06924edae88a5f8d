"""Faults of single channels, and of pairs of them."""
