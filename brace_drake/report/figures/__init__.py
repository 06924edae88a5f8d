"""Figures of a report, one kind per file; `canvas` has their look."""
