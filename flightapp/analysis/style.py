"""The look and the scripts of the report: files beside this package, put into the page whole."""

from __future__ import annotations

from importlib import resources

_SCRIPTS = ("data.js", "map.js", "charts.js", "player.js", "events.js", "start.js")


def style() -> str:
    """The style sheet."""
    return _text("report.css")


def scripts() -> str:
    """All scripts in their order, as one."""
    return '"use strict";\n' + "\n".join(_text(name) for name in _SCRIPTS)


def _text(name: str) -> str:
    return (resources.files("flightapp.analysis") / "assets" / name).read_text(encoding="utf-8")
