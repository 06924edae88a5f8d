"""A score as text and as a picture."""

from __future__ import annotations

import io


def format_score(score: dict) -> str:
    """The figures of merit, the confusion by severity, and every case."""
    lines = [f"{score['cases']} cases", ""]
    for name, share in score["shares"].items():
        lines.append(f"{name:36}{_share(share)}")
    for name, key, scale in (
        ("answers called possible, mean", "answers_per_case", 1.0),
        ("gap closed where right, median, %", "gap_closed_median", 100.0),
        ("gap closed, median, %", "closed_median", 100.0),
        ("CPU seconds a case, median", "seconds_median", 1.0),
        ("log score of the probability", "log_score", 1.0),
        ("Brier score of the probability", "brier_score", 1.0),
    ):
        value = score[key]
        text = "-" if value is None else f"{scale * value:.3g}"
        lines.append(f"{name:36}{text:>9}")
    lines += ["", "probability told, share that was right"]
    for row in score["reliability"]:
        lines.append(f"  {row['told']:.2f}  {_share(row)}")
    for severity, rows in score["confusion"].items():
        lines += ["", f"severity {severity}: truth -> answers"]
        for truth, answers in rows.items():
            counts = ", ".join(f"{a} {n}" for a, n in answers.items())
            lines.append(f"  {truth:34} {counts}")
    lines += ["", f"{'case':9}{'floors':>7}  truth -> answer (probability)"]
    lines += [_line(row) for row in score["each"]]
    return "\n".join(lines) + "\n"


def _share(share: dict) -> str:
    if not share["count"]:
        return "no such case"
    low, high = share["interval"]
    return (
        f"{share['hits']:3d} of {share['count']:3d}"
        f"  {100 * share['share']:5.1f} %"
        f"  (95 %: {100 * low:.1f} to {100 * high:.1f})"
    )


def _line(row: dict) -> str:
    floors = "-" if row["floors"] is None else f"{row['floors']:.2f}"
    p = row["probability"]
    told = "" if p is None else f" ({p:.2f})"
    mark = "" if row["right"] else "  WRONG"
    also = f" or {', '.join(row['possible'])}" if row["possible"] else ""
    severity = f" {row['severity']}" if row["severity"] else ""
    return (
        f"{row['case']:9}{floors:>7}  {row['truth']}{severity}"
        f" -> {row['answer']}{also}{told}{mark}"
    )


def draw_reliability(score: dict) -> str:
    """The reliability diagram as SVG: told against observed."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.0, 4.0), layout="constrained")
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color="0.7", linewidth=1)
    for row in score["reliability"]:
        low, high = row["interval"]
        axes.plot([row["told"]] * 2, [low, high], color="C0", linewidth=1)
        axes.plot(row["told"], row["share"], "o", color="C0")
        axes.annotate(
            f" {row['count']}", (row["told"], row["share"]), fontsize=8
        )
    axes.set(
        xlabel="probability told",
        ylabel="share that was right, 95 % interval",
        xlim=(0.0, 1.05),
        ylim=(0.0, 1.05),
    )
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()
