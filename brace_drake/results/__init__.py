"""What `import brace_drake` offers: load, diagnose, fit and plan.

Each takes a campaign or its folder and the options of the command of the same
name, and returns a result that prints short, shows itself in notebooks, and
becomes tables, figures and files. Nothing is computed here.
"""
