"""Faults of samples and clocks."""
