"""How far the gap shrinks, as a part of the document."""

from __future__ import annotations

import numpy as np

from brace_drake.diagnose import Diagnosis
from brace_drake.validation import shrinkage as shrink


def shrink_part(d: Diagnosis) -> dict | None:
    """Before, after and closed share on validation runs; None without."""
    if not d.validation_runs:
        return None
    runs = d.validation_runs
    repaired = shrink.is_repaired(runs)
    after_key = "after" if repaired else "before"
    before = shrink.total_gap(runs, "before")
    after = shrink.total_gap(runs, after_key)
    channels = d.device.twin.channels
    by_before = shrink.channel_gaps(runs, channels, "before")
    by_after = shrink.channel_gaps(runs, channels, after_key)
    interval = None
    if repaired:
        interval = shrink.closed_interval(runs, d.campaign.rate_hz, d.seed)
    return {
        "runs": [c.prepared.run.name for c in runs],
        "before": before,
        "after": after,
        "floor": 1.0,
        "closed": shrink.closed_share(before, after) if repaired else None,
        "closed_interval": interval,
        "channels": [
            {
                "channel": name,
                "unit": name.rsplit("_", 1)[-1],
                "before": value,
                "after": by_after[name],
                "after_interval": shrink.rms_interval(
                    shrink.channel_squares(
                        runs, channels.index(name), after_key
                    ),
                    d.campaign.rate_hz,
                    d.seed,
                ),
                "floor": 1.0,
                "closed": shrink.closed_share(value, by_after[name])
                if repaired
                else None,
            }
            for name, value in by_before.items()
        ],
        **_quantities(d, repaired),
    }


def _quantities(d: Diagnosis, repaired: bool) -> dict:
    """Errors in the units a user thinks in, over the validation runs.

    Root mean squares before and after, of the floor, and of the measured
    signal itself; 95 % intervals of the first two.
    """
    twin, squares = d.device.twin, {}
    for comparison in d.validation_runs:
        prepared = comparison.prepared
        measured = d.device.quantities(twin, prepared.measured)
        generator = np.random.default_rng([d.seed, 31, prepared.seed])
        exact = twin.simulate(prepared.motion, d.nominal.subject)
        noisy = twin.simulate(prepared.motion, d.nominal.subject, (), generator)
        versions = {
            "before": comparison.before,
            "after": comparison.after if repaired else comparison.before,
        }
        floors = (
            d.device.quantities(twin, exact),
            d.device.quantities(twin, noisy),
        )
        for name, series in measured.items():
            row = squares.setdefault(
                name, {"before": [], "after": [], "floor": [], "signal": []}
            )
            row["signal"].append(np.sum(series**2, axis=1))
            for which, simulated in versions.items():
                other = d.device.quantities(twin, simulated)[name]
                row[which].append(np.sum((series - other) ** 2, axis=1))
            row["floor"].append(
                np.sum((floors[0][name] - floors[1][name]) ** 2, axis=1)
            )
    rate = d.campaign.rate_hz
    return {
        name: {
            which: float(np.sqrt(np.mean(np.concatenate(values))))
            for which, values in row.items()
        }
        | {
            f"{which}_interval": shrink.rms_interval(row[which], rate, d.seed)
            for which in ("before", "after")
        }
        for name, row in squares.items()
    }
