"""Takes out of texts what nobody outside may know.

Out: keys, certificates, passwords, tokens, user names, host names, home folders, serial numbers, hardware addresses, mail
addresses, network names, public network addresses. Left in, because a question about a flight cannot be answered without: where
it was flown, private network addresses (they mean nothing elsewhere), git commits and checksums.
"""

from __future__ import annotations

import ipaddress
import re
from collections import Counter
from collections.abc import Iterable
from typing import Any

MARK = "[redacted]"
NAME_LENGTH_MIN = 3
_COMMON = frozenset({"root", "user", "users", "home", "localhost", "local", "shared", "public", "runs", "flightapp"})
"""Names that tell nobody anything, and would take words out of every log."""

_VALUE = (
    r"(?:(?:bearer|basic)\s+[^\s\"',]+|\"{3}[\s\S]*?\"{3}|'{3}[\s\S]*?'{3}|\"(?:\\.|[^\"\\\n])*\"|'[^'\n]*'"
    r"|\[[^\]]*\]|\{[^}]*\}|\\\"(?:[^\"\\])*\\\"|[^\s,;\"'}\]]+)"
)
_SECRET_WORD = (
    r"(?:password|passwd|passphrase|passcode|pwd|secret|token|api[_ -]?key|private[_-]?key|access[_-]?key|psk|credential)s?"
)
_SECRET_KEY = rf"[\w.-]*{_SECRET_WORD}(?:[_-]\w+)*|authorization|cookie|auth"
_NAME_KEY = (
    r"(?:\w+[_-])?serial(?:[_-]?(?:number|no|id))?|(?:sys|machine|device|hw|board)[_-]?uu?id|uuid|machine[_-]id|imei|imsi|iccid"
    r"|mac(?:[_-]address)?|host[_-]?name|user(?:[_-]?name)?|logname|login|e?ssid|bssid|owner"
)
_PATTERNS = (
    ("key", r"-----BEGIN [A-Z0-9 ]+-----[^\"']*?-----END [A-Z0-9 ]+-----|-----BEGIN [A-Z0-9 ]+-----[^\"']*"),
    ("secret", rf"(?P<secret_key>(?<![\w.-])(?:{_SECRET_KEY})[\"']?\s*(?:=|:(?!//))\s*)(?P<secret_value>{_VALUE})"),
    ("bearer", r"(?P<bearer_key>\b(?:bearer|basic)\s+)(?P<bearer_value>[A-Za-z0-9._~+/=-]{6,})"),
    ("spoken", rf"(?P<spoken_key>\b{_SECRET_WORD}(?:\s+is)?\s+)(?P<spoken_value>[^\s\"',;]+)"),
    ("name", rf"(?P<name_key>(?<![\w.-])(?:{_NAME_KEY})[\"']?\s*(?:=|:(?!//))\s*)(?P<name_value>{_VALUE})"),
    ("login", r"(?P<login_key>\b[a-z][a-z0-9+.-]*://)(?P<login_value>[^\s/@\"']+)(?=@)"),
    ("token", r"\beyJ[\w-]{5,}\.[\w-]+\.[\w-]*|\b(?:gh[pousr]_|github_pat_|glpat-|sk-|xox[abprs]-|AKIA|AIza)[\w-]{8,}"),
    (
        "home",
        r"(?P<home_key>/(?:home|Users|media|run/media)/|[A-Za-z]:(?:\\+|/)Users(?:\\+|/))(?P<home_value>[^\s/\\\"':;,)\]]+)",
    ),
    ("root", r"/root(?=[/\s\"':;,)\]]|$)"),
    ("usb", r"(?P<usb_key>/dev/serial/by-id/[^\s\"']*_)(?P<usb_value>[^\s\"'_]+?)(?=-if\d|[\s\"']|$)"),
    ("address", r"[A-Za-z0-9_.+-]+@[A-Za-z0-9][A-Za-z0-9.-]*"),
    ("hardware", r"(?<![0-9A-Fa-f:])(?:[0-9A-Fa-f]{2}[:-]){5}[0-9A-Fa-f]{2}(?![0-9A-Fa-f:])"),
    ("identity", r"\b[0-9a-fA-F]{8}-(?:[0-9a-fA-F]{4}-){3}[0-9a-fA-F]{12}\b|(?<![0-9A-Za-z])[0-9a-f]{32}(?![0-9A-Za-z])"),
    (
        "network",
        r"(?<![\w.])(?<!==)(?:\d{1,3}\.){3}\d{1,3}(?![\w.]*\d\.)(?!\w)|(?<![\w:.])(?:[0-9a-fA-F]{1,4}:){4,7}[0-9a-fA-F]{1,4}(?![\w:])",
    ),
    ("opaque", r"(?<![A-Za-z0-9+/=])(?=[0-9a-fA-F]*[G-Zg-z+])[A-Za-z0-9+/]{60,}={0,2}"),
)
_SECRET_FIELD = re.compile(rf"(?:{_SECRET_KEY}|{_NAME_KEY})", re.IGNORECASE)
_TEXTS_MAX = 50_000
_PRINTABLE = re.compile(rb"[\t\n\r\x20-\x7e]{8,}")


class Redactor:
    """`names`: what is known to be secret beside the patterns, such as the names of this machine and of its user."""

    def __init__(self, names: Iterable[str] = ()) -> None:
        self._names = tuple(sorted({name for name in names if _tells(name)}, key=len, reverse=True))
        named = "|".join(rf"(?<![A-Za-z0-9]){re.escape(name)}(?![A-Za-z0-9])" for name in self._names)
        patterns = [*([f"(?P<known>{named})"] if named else []), *(f"(?P<{kind}>{pattern})" for kind, pattern in _PATTERNS)]
        self._pattern = re.compile("|".join(patterns), re.IGNORECASE)
        self.counts: Counter[str] = Counter()
        """How much was taken out, by kind."""
        self._clean: set[str] = set()
        self._secret: dict[str, bool] = {"": False}

    def with_names(self, names: Iterable[str]) -> Redactor:
        """One that knows these too."""
        return Redactor([*self._names, *names])

    def text(self, text: str) -> str:
        """The text without; texts that were redacted before stay as they are."""
        previous = None
        while previous != text:
            previous, text = text, self._pattern.sub(self._replaced, text)
        return text

    def value(self, value: Any, key: str = "") -> Any:
        """Decoded JSON without: what stands under a secret key, and what is in any text, names of fields included."""
        if isinstance(value, (bool, int, float)) or value is None:
            return self._under(key, value) if key and not isinstance(value, (bool, float)) and value is not None else value
        if isinstance(value, str):
            return self._under(key, self._known_text(value))
        if isinstance(value, dict):
            return self._under(key, {self._known_text(name): self.value(one, name) for name, one in value.items()})
        return self._under(key, [self.value(one) for one in value])

    def _under(self, key: str, value: Any) -> Any:
        if key not in self._secret:
            self._secret[key] = _SECRET_FIELD.fullmatch(key) is not None
        if not self._secret[key] or value in ("", MARK, [], {}, [MARK]):
            return value
        self.counts["secret"] += 1
        return MARK

    def _known_text(self, text: str) -> str:
        """The same few texts come in every message of a recording."""
        if text not in self._clean:
            redacted = self.text(text)
            if redacted != text:
                return redacted
            if len(self._clean) < _TEXTS_MAX:
                self._clean.add(text)
        return text

    def same_length(self, data: bytes) -> bytes:
        """Bytes of which some may be text: what must go is overwritten by '*', so that lengths and offsets stay."""
        return _PRINTABLE.sub(lambda found: self._starred(found.group()), data)

    def clean(self, data: bytes) -> bool:
        """Whether nothing in these bytes, of which some may be text, must go."""
        return self.same_length(data) == data

    def _starred(self, run: bytes) -> bytes:
        def stars(found: re.Match[str]) -> str:
            kept, value = self._split(found)
            return found.group() if value is None else kept + "*" * (len(found.group()) - len(kept))

        return self._pattern.sub(stars, run.decode("ascii")).encode("ascii")

    def _replaced(self, found: re.Match[str]) -> str:
        kept, value = self._split(found)
        if value is None:
            return found.group()
        mark = f'"{MARK}"' if value.startswith(("[", "{")) or value.isdigit() else MARK
        quote = next((q for q in ('"""', "'''", '\\"', '"', "'") if value.startswith(q) and value.endswith(q)), "")
        done = f"{kept}{quote}{MARK}{quote}" if quote else f"{kept}{mark}"
        if done != found.group():
            self.counts[found.lastgroup or ""] += 1
        return done

    def _split(self, found: re.Match[str]) -> tuple[str, str | None]:
        """(what stays, what goes); None where all may stay."""
        kind = found.lastgroup or ""
        groups = found.groupdict()
        if f"{kind}_value" in groups:
            value = str(groups[f"{kind}_value"])
            return str(groups[f"{kind}_key"]), None if _harmless(kind, value) else value
        return "", None if kind == "network" and not _is_public(found.group()) else found.group()


def home_names(text: str) -> set[str]:
    """Names of people in the home folders that a text mentions."""
    found = re.findall(r"/(?:home|Users)/([A-Za-z0-9._-]+)|[A-Za-z]:(?:\\+|/)Users(?:\\+|/)([A-Za-z0-9._-]+)", text)
    return {name for names in found for name in names if name and _tells(name)}


def _tells(name: str) -> bool:
    return len(name) >= NAME_LENGTH_MIN and name.lower() not in _COMMON and not name.isdigit()


def _harmless(kind: str, value: str) -> bool:
    bare = value.strip("\"'\\ ")
    empty = bare in ("", MARK, "null", "none", "None", "true", "false", "[]", "{}", f'["{MARK}"]') or set(bare) == {"*"}
    return empty or MARK in value or (kind == "home" and not _tells(bare) and bare != "root")


def _is_public(address: str) -> bool:
    try:
        return ipaddress.ip_address(address).is_global
    except ValueError:
        return False
