"""Commands that diagnose, fit, plan and simulate."""
