"""Faults of whole runs, and of what the manifest says of them."""
