"""Damaged files for every reader, and a watch over what a reader does.

A case is good when the reader returns or raises a BraceError, within its time,
without writing anything, reading outside of the case's folder, or running code.
"""

from __future__ import annotations

import contextlib
import os
import random
import shutil
import signal
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from brace_drake.core.errors import BraceError, is_plain
from brace_drake.core.resources import scenario_path

SECONDS = 5.0
# What tears files apart most often, and what must never be obeyed.
WORDS = [
    *(b"nan", b"inf", b"-inf", b"1e999", b"-1", b"0", b"1e-320", b"9" * 40),
    *(b"null", b"true", b"[]", b"{}", b"''", b"~", b"\x00", b"\xff\xfe", b"\r"),
    *(b"../../../../etc/passwd", b"/etc/passwd", b"/tmp", b".", b"..", b""),
    *(b"&a [*a, *a]", b"!!python/object/apply:os.system [touch hit]", b"- "),
    *(b": ", b"\n", b",", b"\t", b"{a: {a: {a: ", b"[" * 200, b"2026-11-22"),
]
VALUES = [
    *(None, True, False, 0, -1, 1, 0.5, -1e-3, 1e308, float("nan")),
    *(float("inf"), 10**30, "", "x", "../../etc/passwd", "/etc/passwd"),
    *("nan", "1e3", [], {}, [1], [[1.0]], {"a": 1}, {1: 2}, "\u0000", "é"),
]
# Places beside the case's folder where a reader may look: code and its cache.
ALLOWED = (
    *(sys.prefix, sys.base_prefix, str(Path(__file__).resolve().parents[1])),
    *(
        "/proc",
        "/sys",
        "/dev/null",
        "/usr",
        "/lib",
        str(Path.home() / ".cache"),
    ),
)
RUNNING = ("os.system", "subprocess.Popen", "pickle.find_class", "os.exec")
CHANGING = ("os.remove", "os.rename", "os.mkdir", "os.rmdir", "os.truncate")


@dataclass(frozen=True)
class Reader:
    """One reader: its sound files, and how it is called.

    Attributes:
        name: For the report.
        write: Writes sound files into an empty folder.
        read: Called with that folder.
        damaged: Names of files that are damaged; a trailing * is all.
    """

    name: str
    write: Callable[[Path], None]
    read: Callable[[Path], object]
    damaged: tuple[str, ...]


class Watch:
    """What Python was asked to do while a case was read."""

    def __init__(self) -> None:
        self.folder: str | None = None
        self.seen: list[str] = []
        sys.addaudithook(self._Hear)

    def _Hear(self, event: str, args: tuple) -> None:
        if self.folder is None:
            return
        if event.startswith(RUNNING):
            self.seen.append(f"{event} {args!r}")
        elif event in CHANGING and not self._is_inside(args[0]):
            self.seen.append(f"{event} {args[0]!r}")
        elif event == "open" and isinstance(args[0], str | bytes):
            path, writes = args[0], self._writes(args)
            if self._is_inside(path):
                if writes:
                    self.seen.append(f"writes {path!r}")
            elif writes or not self._is_code(path):
                self.seen.append(f"opens {path!r}")

    @staticmethod
    def _writes(args: tuple) -> bool:
        mode, flags = args[1], args[2]
        if isinstance(mode, str):
            return any(letter in mode for letter in "wax+")
        return bool((flags or 0) & (os.O_WRONLY | os.O_RDWR | os.O_CREAT))

    def _is_inside(self, path) -> bool:
        real = os.path.realpath(os.fsdecode(path))
        return real.startswith(f"{self.folder}{os.sep}") or real == self.folder

    @staticmethod
    def _is_code(path) -> bool:
        return os.path.realpath(os.fsdecode(path)).startswith(ALLOWED)


_WATCH: Watch | None = None


@contextlib.contextmanager
def watched(folder: Path) -> Iterator[list[str]]:
    """Yields what was done that no reader should do."""
    global _WATCH
    if _WATCH is None:  # An audit hook stays for the life of the process.
        _WATCH = Watch()
    _WATCH.folder, _WATCH.seen = os.path.realpath(folder), []
    try:
        yield _WATCH.seen
    finally:
        _WATCH.folder = None


class HangError(Exception):
    """A reader took longer than it may."""


@contextlib.contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raises HangError when the body computes longer (main thread alone).

    Or waits ten times as long, as others may keep the machine busy.
    """

    def stop(*_):
        raise HangError(f"longer than {seconds:g} s")

    timers = (
        (signal.SIGPROF, signal.ITIMER_PROF, seconds),
        (signal.SIGALRM, signal.ITIMER_REAL, 10.0 * seconds),
    )
    before = [signal.signal(number, stop) for number, _, _ in timers]
    for _, timer, limit in timers:
        signal.setitimer(timer, limit)
    try:
        yield
    finally:
        for (number, timer, _), handler in zip(timers, before, strict=True):
            signal.setitimer(timer, 0.0)
            signal.signal(number, handler)


def damage_bytes(data: bytes, draw: random.Random) -> bytes:
    """One to four random wounds."""
    out = bytearray(data)
    for _ in range(draw.choice((1, 1, 1, 2, 4))):
        at = draw.randrange(len(out) + 1)
        end = min(len(out), at + draw.choice((1, 1, 2, 8, 64)))
        match draw.randrange(6):
            case 0:
                out[at:end] = draw.choice(WORDS)
            case 1:
                out[at:at] = draw.choice(WORDS)
            case 2 if at < len(out):
                out[at] ^= 1 << draw.randrange(8)
            case 3:
                del out[at:end]
            case 4:
                out[at:at] = out[at:end] * draw.choice((1, 2, 50))
            case 5:
                del out[at:]
    return bytes(out)


def damage_tree(data: bytes, draw: random.Random) -> bytes:
    """YAML or JSON with a leaf or a branch replaced, renamed or left out."""
    tree = yaml.safe_load(data)
    places: list[tuple[object, object]] = []

    def walk(node) -> None:
        items = enumerate(node) if isinstance(node, list) else node.items()
        for key, value in items:
            places.append((node, key))
            if isinstance(value, dict | list):
                walk(value)

    if isinstance(tree, dict | list):
        walk(tree)
    if not places:
        return damage_bytes(data, draw)
    node, key = draw.choice(places)
    match draw.randrange(4):
        case 0:
            del node[key]
        case 1 if isinstance(node, dict):
            node[draw.choice(["x", 1, None, f"{key}_", ""])] = node.pop(key)
        case _:
            node[key] = draw.choice(VALUES)
    return yaml.safe_dump(tree).encode()


def damage(path: Path, draw: random.Random) -> None:
    """Damages a file in its place; now and then it goes, or is a folder."""
    chance = draw.random()
    if chance < 0.01:
        path.unlink()
        if draw.random() < 0.5:
            path.mkdir()
        return
    data = path.read_bytes()
    is_tree = path.suffix in (".yaml", ".json")
    if is_tree and chance < 0.6:
        path.write_bytes(damage_tree(data, draw))
    else:
        path.write_bytes(damage_bytes(data, draw))


class Bench:
    """One reader with its sound files, for case after case."""

    def __init__(self, reader: Reader):
        self.reader = reader
        self._home = tempfile.TemporaryDirectory()
        self.sound = Path(self._home.name) / "sound"
        self.sound.mkdir()
        reader.write(self.sound)
        # Imports and first compilations are no part of a case.
        reader.read(self.sound)

    def close(self) -> None:
        """Removes all files."""
        self._home.cleanup()

    def try_case(self, seed: int) -> str | None:
        """Damages by a seed and reads; what went wrong, None where nothing.

        The same seed gives the same damage.
        """
        draw = random.Random(f"{self.reader.name} {seed}")
        case = self._copy()
        names = sorted(
            p
            for pattern in self.reader.damaged
            for p in case.rglob(pattern)
            if p.is_file()
        )
        damage(draw.choice(names), draw)
        return self._read(case)

    def try_file(self, name: str, data: bytes) -> str | None:
        """Reads with one file's content in place of the sound one."""
        case = self._copy()
        (case / name).write_bytes(data)
        return self._read(case)

    def _copy(self) -> Path:
        case = Path(self._home.name) / "case"
        shutil.rmtree(case, ignore_errors=True)
        return Path(shutil.copytree(self.sound, case))

    def _read(self, case: Path) -> str | None:
        problem = None
        with warnings.catch_warnings(), watched(case) as seen:
            try:
                warnings.simplefilter("ignore")
                with time_limit(SECONDS), np.errstate(all="ignore"):
                    self.reader.read(case)
            except BraceError as error:
                if not str(error).strip():
                    problem = f"{type(error).__name__} without a word"
                elif not is_plain(str(error)):
                    problem = f"{type(error).__name__} on several lines"
            except Exception as error:
                problem = f"{type(error).__name__}: {error}"
        return seen[0] if seen else problem


# Readers


def _write_campaign(folder: Path) -> None:
    example = Path(__file__).parent / "data" / "example"
    manifest = yaml.safe_load((example / "campaign.yaml").read_text())
    manifest["runs"] = manifest["runs"][:2]
    for run in manifest["runs"]:
        lines = (example / run["file"]).read_text().splitlines()[:260]
        (folder / run["file"]).write_text("\n".join(lines) + "\n")
    (folder / "campaign.yaml").write_text(yaml.safe_dump(manifest))


def _read_campaign(folder: Path) -> object:
    from brace_drake.recording import CheckCampaign, LoadCampaign

    CheckCampaign(folder)
    return LoadCampaign(folder)


def _write_scenarios(folder: Path) -> None:
    for path in scenario_path("").glob("*.scenario.yaml"):
        shutil.copy(path, folder)


def _read_scenarios(folder: Path) -> object:
    from brace_drake.scenario.load import LoadScenario

    return [LoadScenario(p) for p in sorted(folder.glob("*.scenario.yaml"))]


def _one_scenario(name: str) -> Reader:
    def write(folder: Path) -> None:
        shutil.copy(scenario_path(name), folder)

    kind = name.split(".")[0]
    return Reader(f"scenario {kind}", write, _read_scenarios, ("*.yaml",))


def _write_policy(folder: Path) -> None:
    from brace_drake.learning.policy import SavePolicy
    from tests.learning_tasks import random_policy

    SavePolicy(random_policy(hidden=4), folder / "policy.npz")


def _read_policy(folder: Path) -> object:
    from brace_drake.learning.policy import LoadPolicy

    return LoadPolicy(folder / "policy.npz")


def _write_scan(ending: str) -> Callable[[Path], None]:
    def write(folder: Path) -> None:
        import trimesh

        mesh = trimesh.creation.cylinder(0.14, 0.5, sections=16)
        mesh.apply_scale([0.8, 1.0, 1.0])
        mesh.export(folder / f"scan{ending}")

    return write


def _read_scan(ending: str) -> Callable[[Path], object]:
    def read(folder: Path) -> object:
        from brace_drake.torso.scan import LoadScan

        with contextlib.suppress(BraceError):
            return LoadScan(folder / f"scan{ending}")
        return None

    return read


def _write_of_package(name: str) -> Callable[[Path], None]:
    return lambda folder: shutil.copy(scenario_path(name), folder)


def _read_measures(folder: Path) -> object:
    from brace_drake.torso.measures import LoadMeasures

    return LoadMeasures(folder / "torso_girl13.measures.yaml")


def _read_limits(folder: Path) -> object:
    from brace_drake.link.device.limits_file import LoadLimits

    return LoadLimits(folder / "limits.yaml")


def _read_reference(folder: Path) -> object:
    from brace_drake.devices.motions.reference import LoadReference

    return LoadReference(folder / "paper_push.csv")


def _write_plan(folder: Path) -> None:
    runs = [
        {"motion": "push", "split": "fit", "repeat": False},
        {"motion": "stairs", "split": "validation"},
    ]
    document = {"format": "brace-plan/1", "runs": runs}
    (folder / "plan.yaml").write_text(yaml.safe_dump(document))


def _read_plan(folder: Path) -> object:
    from brace_drake.link.operation.campaign import LoadPlan

    return LoadPlan(folder / "plan.yaml")


def _write_import(folder: Path) -> None:
    columns = {
        "time_s": "Time",
        "displacement_m": {"from": "Travel (mm)", "scale": 0.001},
        "force_N": {"from": "Load", "offset": -0.2},
    }
    document = {
        "format": "brace-import/1",
        "device": "pad bench",
        "subject": "phantom 2",
        "columns": columns,
        "options": {"delimiter": ";", "decimal": ","},
        "runs": [{"file": "first.csv", "motion": "push", "split": "fit"}],
    }
    (folder / "map.yaml").write_text(yaml.safe_dump(document))
    rows = ["Time;Travel (mm);Load"]
    rows += [f"{i / 100},0;{i / 50},5;{i / 9},25" for i in range(10)]
    rows = [rows[0]] + [
        f"{0.01 * i:.2f};{0.02 * i:.2f};{0.5 * i:.2f}".replace(".", ",")
        for i in range(120)
    ]
    (folder / "first.csv").write_text("\n".join(rows) + "\n")


def _read_import(folder: Path) -> object:
    from brace_drake.recording.importing.mapped import ImportCampaign

    return ImportCampaign(folder / "map.yaml")


READERS = (
    Reader("campaign", _write_campaign, _read_campaign, ("*",)),
    _one_scenario("bench.scenario.yaml"),
    _one_scenario("brace.scenario.yaml"),
    _one_scenario("pad_bench.scenario.yaml"),
    Reader("policy", _write_policy, _read_policy, ("*",)),
    *(
        Reader(f"scan {e}", _write_scan(e), _read_scan(e), ("*",))
        for e in (".ply", ".stl", ".obj")
    ),
    Reader(
        "measures",
        _write_of_package("torso_girl13.measures.yaml"),
        _read_measures,
        ("*",),
    ),
    Reader("limits", _write_of_package("limits.yaml"), _read_limits, ("*",)),
    Reader(
        "reference",
        _write_of_package("paper_push.csv"),
        _read_reference,
        ("*",),
    ),
    Reader("plan", _write_plan, _read_plan, ("*",)),
    Reader("import", _write_import, _read_import, ("*",)),
)
