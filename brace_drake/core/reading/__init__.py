"""Files that others wrote: opened, bounded and taken apart here alone.

Nothing in a file is executed, and none of it can take more than bounded time
and memory. Whatever a file holds, its readers end in a result or in one line.
"""

from brace_drake.core.reading.files import ReadBytes, check_file, in_file
from brace_drake.core.reading.json_text import LoadJson, parse_json
from brace_drake.core.reading.text import HUGE, decode
from brace_drake.core.reading.yaml_text import LoadYaml, parse_yaml

__all__ = [
    "HUGE",
    "LoadJson",
    "LoadYaml",
    "ReadBytes",
    "check_file",
    "decode",
    "in_file",
    "parse_json",
    "parse_yaml",
]
