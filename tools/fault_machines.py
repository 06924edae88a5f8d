"""Spoils recordings of single machines as recorders do, and scores verdicts.

    python tools/fault_machines.py --cases 40 --seed 1

Each case draws a machine (an axis or a pad, by closed forms, half of them with
an effect), its noise and the steps of its readings, and a fault of its
recorder; every fifth case is sound. `diagnose` answers it once. Counted are
faults that are named, refused or warned of, 'no gap' with a fault, and faults
that are told of sound recordings. Nothing here knows how faults are found.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from brace_drake.core.errors import BraceError
from brace_drake.diagnosis import diagnose
from brace_drake.recording import LoadCampaign
from brace_drake.recording.recording import Campaign
from brace_drake.recording.write import WriteCampaign
from brace_drake.recording_faults.finding import recording_verdict
from tests import axis_recordings, pad_recordings

Tables = dict[str, dict[str, np.ndarray]]


def make_axis(rng) -> Campaign:
    """An axis with or without an effect of its own."""
    m, c, k = rng.uniform([0.5, 5.0, 20.0], [5.0, 60.0, 300.0])
    level = rng.uniform(0.5, 3.0)
    effects: list[Callable] = [
        lambda p: level * np.tanh(p[:, 1] / 1e-4),
        lambda p: 1e5 * level * p[:, 0] ** 3,
        lambda p: 10.0 * level * np.maximum(p[:, 1], 0.0),
    ]
    effect = effects[rng.integers(3)] if rng.random() < 0.5 else None

    def force(p, beside):
        plain = m * p[:, 2] + c * p[:, 1] + k * p[:, 0]
        return plain if effect is None else plain + effect(p)

    return axis_recordings.make_campaign(force, noise=rng.uniform(0.01, 0.1))


def make_pad(rng) -> Campaign:
    """A pad on tissue with or without an effect."""
    numbers = {
        "k": rng.uniform(600.0, 3000.0),
        "c": rng.uniform(5.0, 40.0),
        "offset": rng.uniform(0.0, 2e-3),
    }
    kind = rng.choice(["linear", "linear", "relaxing", "stiffening"])
    more = rng.uniform(0.3, 1.0)

    def force(motion, t):
        if kind == "stiffening":
            law = pad_recordings.hardening_solid
            return law(motion, t, **numbers, cubic=1e7 * more)
        arm = numbers["k"] * more if kind == "relaxing" else 0.0
        law = pad_recordings.standard_linear_solid
        return law(motion, t, **numbers, arm=arm)

    noise = {"force_noise": rng.uniform(0.01, 0.05)}
    return pad_recordings.make_campaign(force, **noise)


def _some(rng, tables: Tables) -> list[str]:
    """One file, or all."""
    files = list(tables)
    return files if rng.random() < 0.3 else [str(rng.choice(files))]


def _channel(rng, tables: Tables) -> str:
    table = next(iter(tables.values()))
    return str(rng.choice([n for n in table if n != "time_s"]))


def _on_channel(change: Callable) -> Callable:
    """A fault of one channel in one file."""

    def do(rng, tables, others):
        file, name = str(rng.choice(list(tables))), _channel(rng, tables)
        tables[file][name] = change(rng, tables[file][name].copy())
        return f"{name} of {file}"

    return do


def _unit(rng, tables, others):
    name = _channel(rng, tables)
    sizes = {"m": [1e3, 1e2, 39.37], "N": [0.10197, 0.22481, 1e3]}
    size = float(rng.choice(sizes[name.rsplit("_", 1)[1]]))
    file = str(rng.choice(list(tables)))
    tables[file][name] = tables[file][name] * size
    return f"{name} of {file} by {size:g}"


def _stuck(rng, x):
    x[int(rng.uniform(0.2, 0.6) * len(x)) :] = x[int(0.2 * len(x))]
    return x


def _clip(rng, x):
    return np.clip(x, *np.quantile(x, [0.03, 0.9]))


def _outliers(rng, x):
    at = rng.choice(len(x), max(3, len(x) // 200), replace=False)
    x[at] += rng.choice([-1, 1], len(at)) * 5.0 * np.std(x)
    return x


def _drop(rng, tables, others):
    files = _some(rng, tables)
    for file in files:
        n = len(tables[file]["time_s"])
        keep = np.ones(n, dtype=bool)
        for _ in range(rng.integers(1, 4)):
            begin = int(rng.uniform(0.2, 0.8) * n)
            keep[begin : begin + rng.integers(15, 60)] = False
        time = tables[file]["time_s"][: keep.sum()]
        cut = {c: x[keep] for c, x in tables[file].items()}
        tables[file] = {**cut, "time_s": time}
    return f"blocks of {', '.join(files)}"


def _twice(rng, tables, others):
    file = str(rng.choice(list(tables)))
    n, size = len(tables[file]["time_s"]), int(rng.integers(20, 80))
    at = int(rng.uniform(0.3, 0.7) * n)
    order = np.r_[np.arange(at), np.arange(at - size, n - size)]
    time = tables[file]["time_s"]
    tables[file] = {c: x[order] for c, x in tables[file].items()}
    tables[file]["time_s"] = time
    return f"{size} rows of {file} at {at}"


def _late(rng, tables, others):
    name, rows = _channel(rng, tables), int(rng.integers(8, 25))
    files = _some(rng, tables)
    for file in files:
        x = tables[file][name]
        tables[file][name] = np.r_[np.full(rows, x[0]), x[:-rows]]
    return f"{name} of {', '.join(files)} by {rows} rows"


def _backwards(rng, tables, others):
    file = str(rng.choice(list(tables)))
    for name, x in tables[file].items():
        if name != "time_s":
            tables[file][name] = x[::-1].copy()
    return file


def _other_machine(rng, tables, others):
    file = str(rng.choice(list(tables)))
    tables[file] = others[file]
    return file


def _exchange(rng, tables, others):
    a, b = map(str, rng.choice(list(tables), 2, replace=False))
    tables[a], tables[b] = tables[b], tables[a]
    return f"{a} and {b}"


def _copy(rng, tables, others):
    *fit, validation = tables
    source = str(rng.choice(fit))
    tables[validation] = {c: x.copy() for c, x in tables[source].items()}
    return f"{source} as {validation}"


def _constant(rng, x):
    return np.full_like(x, x[0])


FAULTS: dict[str, Callable] = {
    "sign": _on_channel(lambda rng, x: -x),
    "unit": _unit,
    "scale": _on_channel(lambda rng, x: x * rng.choice([0.5, 1.5, 2.0])),
    "stuck": _on_channel(_stuck),
    "constant": _on_channel(_constant),
    "clipped": _on_channel(_clip),
    "outliers": _on_channel(_outliers),
    "moved zero": _on_channel(lambda rng, x: x + 0.5 * np.std(x)),
    "lost blocks": _drop,
    "block twice": _twice,
    "late": _late,
    "backwards": _backwards,
    "other machine": _other_machine,
    "copy": _copy,
    # Without a command to hold it to, an exchange of files whose motions are
    # not stated changes nothing but names; a repeat tells it.
    "exchanged files": _exchange,
}


def draw(seed: int, place: int) -> tuple[str, str, Campaign]:
    """Kind of fault, what was done, and the campaign."""
    rng = np.random.default_rng([seed, place])
    make = make_axis if rng.random() < 0.5 else make_pad
    sound, other = make(rng), make(rng)
    tables = {r.file: dict(r.channels) for r in sound.runs}
    others = {r.file: dict(r.channels) for r in other.runs}
    kind = "sound" if place % 5 == 4 else str(rng.choice(list(FAULTS)))
    done = "" if kind == "sound" else FAULTS[kind](rng, tables, others)
    runs = tuple(replace(r, channels=tables[r.file]) for r in sound.runs)
    return kind, f"{sound.device}: {done}", replace(sound, runs=runs)


def answer(campaign: Campaign) -> tuple[str, str]:
    """What is said of a campaign, as its user meets it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "campaign"
        WriteCampaign(campaign, path)
        try:
            found = diagnose(LoadCampaign(path), jobs=1)
        except BraceError as error:
            return "refused", str(error).replace(folder, "")
    told = recording_verdict(found.recording)
    if "sentence" in told:
        return "named", told["sentence"]
    if found.recording:
        return "warned", found.recording[0].sentence()
    verdict = found.verdict
    if not verdict.gap:
        return "no gap", ""
    if verdict.outside_library:
        return "outside", ""
    if verdict.winner is None:
        return "unconfirmed", ""
    return "effect", verdict.winner.name


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cases", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    counts: dict[str, dict[str, int]] = {"sound": {}, "fault": {}}
    for place in range(args.cases):
        begun = time.perf_counter()
        kind, done, campaign = draw(args.seed, place)
        word, said = answer(campaign)
        group = counts["sound" if kind == "sound" else "fault"]
        group[word] = group.get(word, 0) + 1
        took = time.perf_counter() - begun
        print(f"{place:02d} {kind} ({done}): {word} [{took:.0f} s]", flush=True)
        print(f"    {said[:150]}", flush=True)
    print(counts)
    return 0


if __name__ == "__main__":
    sys.exit(main())
