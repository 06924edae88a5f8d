"""Methods beside each other: a row each, shares with Wilson's intervals."""

from __future__ import annotations

from collections.abc import Mapping

# Heading of each column, and the share that is in it.
_COLUMNS = {
    "which": "effects: exactly those at fault",
    "where": "blocks: exactly those at fault",
    "foreign told": "outside: recall",
    "no gap": "no gap where there is none",
    "wrong name, p > 0.8": "wrong names with p above 0.8",
    "how far: 80 % closed": "gap closed by 80 % or more",
}


def format_table(scores: Mapping[str, dict]) -> str:
    """A Markdown table of scores, by method."""
    head = ["method", *_COLUMNS, "closed, median", "CPU s a case, median"]
    lines = [_row(head), _row(["---"] * len(head))]
    for method, score in scores.items():
        shares = [_share(score["shares"][key]) for key in _COLUMNS.values()]
        closed, seconds = score["closed_median"], score["seconds_median"]
        lines.append(
            _row(
                [
                    method,
                    *shares,
                    "-" if closed is None else f"{100 * closed:.0f} %",
                    "-" if seconds is None else f"{seconds:.3g}",
                ]
            )
        )
    return "\n".join(lines) + "\n"


def _row(cells: list[str]) -> str:
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"


def _share(share: dict) -> str:
    """Hits of how many, and the interval in percent."""
    if not share["count"]:
        return "-"
    low, high = (round(100 * end) for end in share["interval"])
    return f"{share['hits']} of {share['count']} ({low} to {high} %)"
