"""Draws the top of a report as the picture of docs/images/diagnosis.png.

    make demo
    python tools/draw_diagnosis.py out/demo/report.html diagnosis.png

Needs Chromium or Chrome on the PATH. Status 1 where there is none, or where it
leaves no picture.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

_BROWSERS = ("chromium", "chromium-browser", "google-chrome")
_SIZE = (1120, 960)
_PATIENCE_S = 120.0


def draw_page(browser: str, page: Path, out: Path) -> bool:
    """Writes the top of a page as PNG; whether a picture came of it."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "page.png"
        subprocess.run(
            [
                browser,
                "--headless",
                "--disable-gpu",
                "--no-sandbox",
                "--hide-scrollbars",
                # Time for the charts, which scripts draw.
                "--virtual-time-budget=4000",
                f"--user-data-dir={folder}/profile",
                f"--window-size={_SIZE[0]},{_SIZE[1]}",
                f"--screenshot={made}",
                page.resolve().as_uri(),
            ],
            capture_output=True,
            timeout=_PATIENCE_S,
        )
        if not made.is_file():
            return False
        shutil.copyfile(made, out)
    return True


def main() -> int:
    """Draws one report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("report", type=Path, help="report.html of a diagnosis")
    parser.add_argument("out", type=Path, help="*.png")
    args = parser.parse_args()
    browser = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if browser is None:
        print(f"none of {', '.join(_BROWSERS)} is there", file=sys.stderr)
        return 1
    if not args.report.is_file():
        print(f"{args.report}: no such report", file=sys.stderr)
        return 1
    if not draw_page(browser, args.report, args.out):
        print(f"{args.report}: {browser} left no picture", file=sys.stderr)
        return 1
    print(f"picture: {args.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
