"""Says what a machine lacks before anything is installed on it.

Uses the standard library only and runs on old Pythons too.
"""

import ctypes.util
import platform
import sys

# Shared libraries that the drake wheel takes from the system.
LIBRARIES = {"glib-2.0": "libglib2.0-0"}


def problems():
    """One line for each thing that is missing, with what to do."""
    found = []
    version = sys.version_info[:2]
    if not (3, 11) <= version <= (3, 13):
        found.append(
            "Python 3.11 to 3.13 is needed, this is {}.{}; say e.g."
            " `make demo PYTHON=python3.11`".format(*version)
        )
    try:
        import ensurepip  # noqa: F401
        import venv  # noqa: F401
    except ImportError:
        found.append(
            "Python's venv module is missing: apt-get install"
            " python{}.{}-venv".format(*version)
        )
    if platform.system() == "Linux":
        if platform.machine() not in ("x86_64", "AMD64"):
            found.append(
                "drake has no wheel for Linux on " + platform.machine()
            )
        for library, package in LIBRARIES.items():
            if ctypes.util.find_library(library) is None:
                found.append(
                    f"lib{library} is missing: apt-get install {package}"
                )
    return found


if __name__ == "__main__":
    lines = problems()
    for line in lines:
        print(line, file=sys.stderr)
    sys.exit(2 if lines else 0)
