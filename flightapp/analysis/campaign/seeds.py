"""Seeds as a person writes them: `17`, `0-999`, `3,5,20-29`, and `10000-` where the number of seeds is known otherwise."""

from __future__ import annotations

import re

from flightapp.core.errors import InputError

SEEDS_MAX = 1_000_000
_PART = re.compile(r"(\d{1,9})(?:-(\d{1,9}))?")
_WANTED = "write one seed (17), a range (0-999) or several of them (3,5,20-29)"


def parse_seeds(text: str, option: str = "--seeds") -> tuple[int, ...]:
    """The seeds that `text` names, rising, each once; InputError, which begins with `option`, on anything else."""
    seeds: set[int] = set()
    for part in text.split(","):
        found = _PART.fullmatch(part.strip())
        if found is None:
            raise InputError(f"{option} {text}: '{part.strip()}' is not a seed or a range of seeds; {_WANTED}")
        first, last = int(found[1]), int(found[2] or found[1])
        if last < first:
            raise InputError(f"{option} {text}: the range {part.strip()} ends before it begins; write {last}-{first}")
        if last - first >= SEEDS_MAX:
            raise InputError(f"{option} {text}: more than {SEEDS_MAX} seeds; name fewer")
        seeds.update(range(first, last + 1))
    return tuple(sorted(seeds))


def parse_batch(text: str, batch: int) -> tuple[int, ...]:
    """The first `batch` seeds of `text`, which may be open (`10000-`); InputError if it names fewer."""
    opened = re.fullmatch(r"(\d{1,9})-", text.strip())
    if opened is not None:
        return tuple(range(int(opened[1]), int(opened[1]) + batch))
    seeds = parse_seeds(text)
    if len(seeds) < batch:
        raise InputError(f"--seeds {text}: {len(seeds)} seeds for a batch of {batch}; name more, or a smaller --batch")
    return seeds[:batch]


def seeds_text(seeds: tuple[int, ...]) -> str:
    """The shortest way to write rising `seeds`, such that parse_seeds gives them again."""
    parts: list[list[int]] = []
    for seed in seeds:
        if parts and seed == parts[-1][1] + 1:
            parts[-1][1] = seed
        else:
            parts.append([seed, seed])
    return ",".join(f"{first}" if first == last else f"{first}-{last}" for first, last in parts)
