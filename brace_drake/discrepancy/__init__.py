"""What no effect of the library explains gets a law of its own.

`search` looks for a law of at most three terms of the dictionary
(`effects.unknown`) in the closed loop, beside the effects that are named or,
where effects of dozens of parameters would be tried, in place of any; `law`
holds what was found and what it closes on runs that no fit has seen.
"""

from brace_drake.discrepancy.law import FoundLaw, find_law
from brace_drake.discrepancy.search import LawSearch

__all__ = ["FoundLaw", "LawSearch", "find_law"]
