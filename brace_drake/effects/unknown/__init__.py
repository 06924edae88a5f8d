"""Terms of which laws of unknown forces are made, place by place.

None of them is a cause: they say what an effect that the library has not looks
like. `forms` says what each term depends on, `places` where it acts, and
`dictionary` puts both together as cards that a twin takes as it takes effects.
"""

from brace_drake.effects.unknown.dictionary import (
    describe_term,
    is_term,
    parts_of_term,
    terms_for,
)

__all__ = ["describe_term", "is_term", "parts_of_term", "terms_for"]
