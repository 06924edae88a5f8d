"""Spoils sound campaigns as recorders do, and scores what is answered.

    python tools/fault_recordings.py make SOURCE... --out DIR [--blind 40]
    python tools/fault_recordings.py score DIR [--twin]

`make` writes one folder for each named fault, or so many drawn by a seed over
kinds, sources and sizes, with what was done in `fault.yaml` beside them.
`score` answers each once: `refused` where the check has errors, `named` where
a fault is found against the twin with the effects of the source's label (none
without one), else `no gap` or `gap` by what that twin leaves. Runs of another
subject are put among those of the same machine: into campaigns without effects
(`--clean`). Nothing here knows how faults are found.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import yaml

Table = dict[str, np.ndarray]


class Spoiled:
    """A copy of a campaign that faults are put into.

    Attributes:
        manifest: campaign.yaml.
        tables: Columns of each file.
        donor: Another campaign, for what comes from elsewhere.
        rng: Of all that is drawn.
    """

    def __init__(self, source: Path, donor: Path, seed: int):
        self.source, self.donor = source, donor
        self.manifest = yaml.safe_load((source / "campaign.yaml").read_text())
        self.tables = {r["file"]: read(source / r["file"]) for r in self.runs}
        self.rng = np.random.default_rng(seed)

    @property
    def runs(self) -> list[dict]:
        return self.manifest["runs"]

    def files(self, *, contact=None, split=None, moving=False) -> list[str]:
        return [
            r["file"]
            for r in self.runs
            if contact in (None, r["contact"])
            and split in (None, r["split"])
            and not (moving and "hold" in r["file"])
        ]

    def some(self, **which) -> list[str]:
        """All files of a kind, or one of them."""
        files = self.files(**which)
        return files if self.rng.random() < 0.5 else [self.rng.choice(files)]

    def map(self, files, column: str, change: Callable) -> None:
        for file in files:
            self.tables[file][column] = change(self.tables[file][column])

    def swap(self, files, a: str, b: str) -> None:
        for file in files:
            t = self.tables[file]
            t[a], t[b] = t[b], t[a]

    def changed(self) -> dict[str, list[str]]:
        """Columns of each file that are not the source's any more."""
        found = {}
        for file, table in self.tables.items():
            before = read(self.source / file)
            names = [
                n
                for n in before
                if n not in table or not np.array_equal(before[n], table[n])
            ]
            if names:
                found[file] = names if len(names) < 8 else ["most"]
        return found

    def write(self, out: Path) -> None:
        out.mkdir(parents=True)
        (out / "campaign.yaml").write_text(yaml.safe_dump(self.manifest))
        for file, table in self.tables.items():
            names = list(table)
            rows = np.column_stack([table[n] for n in names])
            text = [",".join(names)]
            text += [",".join(f"{v:.9g}" for v in row) for row in rows]
            (out / file).write_text("\n".join(text) + "\n")


def read(path: Path) -> Table:
    names = path.read_text().split("\n", 1)[0].split(",")
    values = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    return dict(zip(names, values.T, strict=True))


def leg(k, kind):
    return f"leg{k}_length_m" if kind == "length" else f"leg{k}_force_command_N"


def exchange(kind):
    def do(s, files=None):
        a, b = s.rng.choice(np.arange(1, 7), 2, replace=False)
        s.swap(files or s.some(moving=True), leg(a, kind), leg(b, kind))

    return do


def exchange_markers(s):
    a, b = s.rng.choice(["x", "y", "z"], 2, replace=False)
    s.swap(s.files(contact=True), f"torso_{a}_m", f"torso_{b}_m")


def exchange_forces(s):
    axis = s.rng.choice(["x", "z"])
    files = s.files(contact=True)
    s.swap(files, "ring2_force_y_N", f"ring2_force_{axis}_N")


def kgf(s, files=None, k=None):
    k = k or s.rng.integers(1, 7)
    s.map(files or s.some(), leg(k, "command"), lambda v: v / 9.80665)


def force_unit(s):
    size = s.rng.choice([9.80665, 4.4482216, 0.1])
    for axis in "xyz":
        s.map(
            s.files(contact=True), f"ring2_force_{axis}_N", lambda v: v / size
        )


def scale_length(s):
    gain = s.rng.choice([0.9, 1.05, 1.1])
    name = leg(s.rng.integers(1, 7), "length")
    s.map(s.some(moving=True), name, lambda v: v * gain)


def marker_scale(s):
    gain = s.rng.choice([-1.0, 0.3937, 2.54, 10.0])
    name = f"torso_{s.rng.choice(['y', 'y', 'x'])}_m"
    s.map(s.files(contact=True), name, lambda v: v * gain)


def stuck(kind):
    def do(s, whole=True):
        file = s.rng.choice(s.files(contact=True, moving=True))
        name = leg(s.rng.integers(1, 7), "length")
        if kind == "force":
            name = "ring2_force_y_N"
        x = s.tables[file][name]
        start = 0 if whole else int(s.rng.uniform(0.2, 0.7) * len(x))
        x[start:] = x[start]

    return do


def clip(s, level=None):
    for file in s.files(contact=True):
        x = s.tables[file]["ring2_force_y_N"]
        top = level or 0.6 * np.abs(x).max()
        np.clip(x, -top, top, out=x)


def outliers(s, share=0.01, files=None):
    kinds = [leg(s.rng.integers(1, 7), "length"), "ring2_force_y_N"]
    kinds.append("torso_y_m")
    for file in files or s.files(contact=True):
        for name in kinds:
            x = s.tables[file][name]
            at = s.rng.choice(len(x), max(2, int(share * len(x))), False)
            x[at] += (
                s.rng.choice([-1, 1], len(at))
                * s.rng.uniform(3, 10, len(at))
                * max(x.std(), 1e-4)
            )


def drop(s, files=None):
    for file in files or s.some(moving=True):
        t = s.tables[file]
        keep = np.ones(len(t["time_s"]), bool)
        for _ in range(s.rng.integers(2, 6)):
            start = int(s.rng.uniform(0.1, 0.9) * len(keep))
            keep[start : start + s.rng.integers(5, 60)] = False
        time = t["time_s"][: keep.sum()]
        for name in t:
            t[name] = t[name][keep]
        t["time_s"] = time


def repeat_block(s):
    t = s.tables[s.rng.choice(s.files(moving=True))]
    n = len(t["time_s"])
    at, size = int(s.rng.uniform(0.2, 0.8) * n), int(s.rng.integers(8, 60))
    order = np.concatenate([np.arange(at), np.arange(at - size, n - size)])
    for name in t:
        if name != "time_s":
            t[name] = t[name][order]


def wrong_rate(s, ratio=None, rewrite=False):
    """Sampled at ratio times the rate that is written down."""
    ratio = ratio or s.rng.choice([0.5, 0.9, 0.95, 1.05, 0.997])
    for t in s.tables.values():
        time = t["time_s"]
        true = time[0] + np.arange(int(len(time) * ratio)) * 0.005 / ratio
        true = true[true <= time[-1]]
        for name in t:
            if name != "time_s":
                t[name] = np.interp(true, time, t[name])
        t["time_s"] = time[0] + 0.005 * np.arange(len(true))


def slow_clock(s, ratio=1.003):
    for t in s.tables.values():
        t["time_s"] = t["time_s"] * ratio


def skew(s):
    groups = [
        [leg(k, "length") for k in range(1, 7)],
        [f"ring2_force_{a}_N" for a in "xyz"],
        [f"torso_{a}_m" for a in "xyz"],
        [leg(k, "command") for k in range(1, 7)],
        [leg(s.rng.integers(1, 7), "length")],
    ]
    names, late = groups[s.rng.integers(5)], int(s.rng.integers(3, 20))
    for t in s.tables.values():
        for name in t:
            t[name] = t[name][:-late] if name in names else t[name][late:]


def exchange_files(s, a="push.csv", b="multisine.csv"):
    s.tables[a], s.tables[b] = s.tables[b], s.tables[a]


def exchange_any_files(s):
    a, b = s.rng.choice(s.files(contact=True, split="fit"), 2, replace=False)
    if "repeat" not in a and "push" not in a:
        a = "push_repeat.csv"
    if a != b:
        exchange_files(s, a, b)


def call_free_contact(s):
    for r in s.runs:
        r["contact"] = True


def flip_contact(s):
    s.runs[
        [r["file"] for r in s.runs].index(s.rng.choice(s.files(moving=True)))
    ]["contact"] ^= True


def false_repeat(s):
    r = next(r for r in s.runs if r["file"] == "stairs.csv")
    r["repeat_of"] = "push.csv"


def from_donor(s, files):
    for file in files:
        s.tables[file] = read(s.donor / file)


def other_patients(s):
    fit = s.files(contact=True, split="fit")
    from_donor(s, s.rng.choice(fit, s.rng.integers(2, 4), replace=False))


def other_validation(s):
    from_donor(s, s.files(split="validation"))


def copy_validation(s):
    s.tables["validation_push.csv"] = {
        k: v.copy() for k, v in s.tables["push.csv"].items()
    }


def double_validation(s):
    for axis in "xyz":
        name = f"ring2_force_{axis}_N"
        s.map(s.files(split="validation"), name, lambda v: 2.0 * v)


def all_constant(s):
    for t in s.tables.values():
        for name in t:
            if name != "time_s":
                t[name][:] = t[name][0]


def flip_without_virtual(s):
    s.map(s.files(), "ring2_force_y_N", np.negative)
    for t in s.tables.values():
        t.pop("ring2_y_virtual_m")


def shifted_zero(s):
    name = leg(s.rng.integers(1, 7), "length")
    s.map(s.some(moving=True), name, lambda v: v + s.rng.choice([-2e-3, 2e-3]))


def flip_command(s):
    s.map(s.some(), leg(s.rng.integers(1, 7), "command"), np.negative)


def geometry(s):
    """The bench with wider joint circles, recorded anew."""
    from tools.fault_geometry import record_wider

    for i, r in enumerate(s.runs):
        record_wider(s.tables[r["file"]], r["contact"], i)


NAMED: dict[str, Callable] = {
    "validation forces doubled": double_validation,
    "validation of another patient": other_validation,
    "push and multisine exchanged": exchange_files,
    "two lengths exchanged": lambda s: exchange("length")(s, s.files()),
    "two commands exchanged": lambda s: exchange("command")(s, s.files()),
    "kgf on one leg": lambda s: kgf(s, s.files()),
    "stuck length": stuck("length"),
    "stuck force": stuck("force"),
    "force clipped at 4 N": lambda s: clip(s, 4.0),
    "1 % outliers": outliers,
    "190 Hz called 200": lambda s: wrong_rate(s, 0.95),
    "clock 0.3 % off": slow_clock,
    "two patients": other_patients,
    "blocks dropped": lambda s: drop(s, s.files(moving=True)),
    "all constant": all_constant,
    "validation is a copy": copy_validation,
    "free runs called contact": call_free_contact,
    "flipped force without virtual": flip_without_virtual,
    "another geometry": geometry,
}
BLIND: dict[str, Callable] = {
    "exchanged lengths": exchange("length"),
    "exchanged commands": exchange("command"),
    "exchanged markers": exchange_markers,
    "exchanged forces": exchange_forces,
    "kgf on a leg": kgf,
    "force unit": force_unit,
    "length scale": scale_length,
    "marker scale": marker_scale,
    "stuck length for a while": lambda s: stuck("length")(s, False),
    "stuck force for a while": lambda s: stuck("force")(s, False),
    "clipped force": clip,
    "few outliers": lambda s: outliers(s, 0.002, s.some(contact=True)),
    "dropped blocks": drop,
    "repeated block": repeat_block,
    "wrong rate": wrong_rate,
    "skewed channels": skew,
    "exchanged files": exchange_any_files,
    "flipped contact": flip_contact,
    "false repeat": false_repeat,
    "other patients": other_patients,
    "other validation": other_validation,
    "moved zero": shifted_zero,
    "flipped command": flip_command,
}


def make(args) -> None:
    sources = [Path(p) for p in args.sources]
    rng = np.random.default_rng(args.seed)
    if args.blind:
        kinds = list(BLIND)
        jobs = [
            (kinds[i % len(kinds)] if i < len(kinds) else rng.choice(kinds))
            for i in range(args.blind)
        ]
        table = BLIND
    else:
        jobs, table = list(NAMED), NAMED
    for i, kind in enumerate(jobs):
        source = sources[rng.integers(len(sources)) if args.blind else 0]
        donor = Path(args.donor or source)
        if kind.startswith("other") and len(args.clean) > 1:
            source, donor = map(Path, rng.permutation(args.clean)[:2])
        spoiled = Spoiled(source, donor, args.seed + i)
        table[kind](spoiled)
        out = Path(args.out) / f"fault{i:02d}"
        shutil.rmtree(out, ignore_errors=True)
        spoiled.write(out)
        note = {"kind": str(kind), "source": source.name, "seed": args.seed + i}
        note["path"] = str(source.resolve())
        note |= {"changed": spoiled.changed()}
        (out / "fault.yaml").write_text(yaml.safe_dump(note))


def known_effects(path: Path, about: dict) -> list:
    """Effects that the label of a spoiled campaign's source names: what the
    diagnosis would have found on the sound one, none without a label.
    """
    from brace_drake.core.errors import EffectError
    from brace_drake.effects.registry import find_effect

    label = Path(about.get("path", "")) / "label.yaml"
    if not label.is_file():
        return []
    try:
        names = yaml.safe_load(label.read_text())["effects"]
        return [find_effect(name) for name in names]
    except EffectError:
        return []


def answer(path: Path, twin: bool, about: dict) -> tuple[str, list[str]]:
    """What is said of a campaign, and the faults that are named."""
    from brace_drake.core.errors import BraceError
    from brace_drake.devices.device import MakeDevice
    from brace_drake.recording import LoadCampaign
    from brace_drake.recording_faults import check_recording
    from brace_drake.recording_faults.against_twin import judge_campaign

    try:
        campaign = LoadCampaign(path)
    except BraceError as error:
        return "refused", [str(error).split(": ", 1)[-1][:90]]
    device = MakeDevice(campaign)
    found = check_recording(campaign, device)
    if found or not twin:
        refused = any(f.severity == "error" for f in found)
        word = "refused" if refused else "warned" if found else "passed"
        return word, [f.sentence() for f in found]
    effects = known_effects(path, about)
    judged, misfit = judge_campaign(campaign, device, effects)
    if judged:
        return "named", [f.sentence() for f in judged]
    return "no gap" if misfit < 0.05 else "gap", [f"misfit {misfit:.3g}"]


def score(args) -> None:
    counts: dict[str, int] = {}
    for folder in sorted(p for p in Path(args.folder).iterdir() if p.is_dir()):
        begun = time.perf_counter()
        note = folder / "fault.yaml"
        about, kind = {}, "sound"
        if note.is_file():
            about = yaml.safe_load(note.read_text())
            kind = f"{about['kind']} ({about['source']})"
        word, said = answer(folder, args.twin, about)
        counts[word] = counts.get(word, 0) + 1
        took = time.perf_counter() - begun
        print(f"{folder.name} {kind}: {word} [{took:.0f} s]", flush=True)
        for line in said[:4]:
            print(f"    {line}", flush=True)
    print(counts, flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    commands = parser.add_subparsers(required=True)
    one = commands.add_parser("make")
    one.add_argument("sources", nargs="+")
    one.add_argument("--donor", help="another subject's campaign")
    one.add_argument("--clean", nargs="*", default=[], help="without effects")
    one.add_argument("--out", required=True)
    one.add_argument("--blind", type=int, default=0)
    one.add_argument("--seed", type=int, default=0)
    one.set_defaults(run=make)
    two = commands.add_parser("score")
    two.add_argument("folder")
    two.add_argument("--twin", action="store_true")
    two.set_defaults(run=score)
    args = parser.parse_args()
    args.run(args)
    return 0


if __name__ == "__main__":
    sys.exit(main())
