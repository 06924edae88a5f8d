"""Is closing the gap worth it? A sim-to-real experiment (`brace-drake payoff`).

Policies trained on the nominal and on the repaired twin push the independent
simulator of the bench, which stands for the machine.
"""
