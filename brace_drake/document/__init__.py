"""A finished diagnosis as plain data: diagnosis.json and traces for a report.

Nothing is computed here; `diagnose` has done it all.
"""
