"""Faults that only the fitted twin shows."""
