"""What the numbers of a parameter's choices stand for."""

_WORDS = {
    "pad": ("both pads", "pad at +y", "pad at -y"),
    "forgets": ("kept while the pad is off", "lost once the pad is off"),
}


def choice_words(name: str, value: float) -> str | None:
    """A choice in words, None where its number says it, as a leg's does."""
    words = _WORDS.get(name, ())
    known = value in range(len(words))
    return words[int(value)] if known else None
