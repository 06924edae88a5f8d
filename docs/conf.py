"""Sphinx: guides in MyST, reference from docstrings, warnings are errors."""

import gc
import sys
from pathlib import Path

# The collector would walk through all pages again and again: half of a build.
gc.disable()

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(Path(__file__).parent)]

from reference import WriteReference  # noqa: E402

from brace_drake.cli.main import make_parser  # noqa: E402

project = "brace_drake"
author = "the brace_drake authors"
copyright = "2026, the brace_drake authors"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
]
exclude_patterns = ["_build", "README.md"]
html_theme = "furo"
# Names of functions would be copied into the navigation of every page.
toc_object_entries = False
html_title = "brace_drake"
html_theme_options = {"navigation_with_keys": True}

myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3
# Names of attributes need not be the only ones of their kind.
suppress_warnings = ["ref.python"]

# Prose of docstrings is plain text with `names` in it.
default_role = "any_or_code"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False


def setup(app):
    """Writes the pages that are made from the code, then lets it begin."""
    from docstrings import as_rst
    from docutils import nodes

    def code(name, rawtext, text, lineno, inliner, options=None, content=()):
        return [nodes.literal(rawtext, text)], []

    app.add_role("any_or_code", code)
    app.connect("autodoc-process-docstring", as_rst, priority=100)
    WriteReference(Path(app.srcdir) / "reference", make_parser())
