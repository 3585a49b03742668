"""The command line: a live or recorded camera -> pictures, video, a web page, lists of discs."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from perception.errors import PerceptionInputError
from perception.view.arguments import parse
from perception.view.run import run


def main(arguments: Sequence[str] | None = None) -> int:
    """Returns the exit status: 0, or 2 on bad input."""
    try:
        run(parse(arguments))
    except PerceptionInputError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0
