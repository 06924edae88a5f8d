"""Commands as a user gives them, run within the test's own process."""

import contextlib
import io

from brace_drake.cli.main import main


def run_command(*words):
    """Status, standard output and standard error of `brace-drake words...`."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main([str(word) for word in words])
    return status, out.getvalue(), err.getvalue()
