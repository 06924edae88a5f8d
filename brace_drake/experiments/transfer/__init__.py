"""Does closing the gap pay? Policies of twins on the machine they stand for."""
