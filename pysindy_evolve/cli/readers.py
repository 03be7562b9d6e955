"""Readers that convert the text after a flag; argparse reports their errors with the flag."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from pathlib import Path


def names(text: str) -> tuple[str, ...]:
    """Read different names, separated by commas."""
    found = tuple(name.strip() for name in text.split(","))
    if not all(found) or len(set(found)) < len(found):
        raise argparse.ArgumentTypeError(f"must be different names with commas; got {text!r}")
    return found


def columns(text: str) -> dict[str, str]:
    """Read names, separated by commas; ``q=Position [mm]`` gives a column the name q."""
    parts = [part.partition("=") for part in text.split(",")]
    found = names(",".join(name for name, _, _ in parts))
    in_file = (column.strip() if sign else name.strip() for name, sign, column in parts)
    return dict(zip(found, in_file, strict=True))


def choices(known: Sequence[str]) -> Callable[[str], tuple[str, ...]]:
    """Return a reader of known names, separated by commas."""

    def read(text: str) -> tuple[str, ...]:
        found = names(text)
        if unknown := [name for name in found if name not in known]:
            raise argparse.ArgumentTypeError(
                f"must be some of {', '.join(known)}; got {unknown[0]!r}"
            )
        return found

    return read


def pair(flag: str, example: str) -> Callable[[str], tuple[str, str]]:
    """Return a reader of ``name = text``; a prime after the name is left out."""

    def read(text: str) -> tuple[str, str]:
        name, sign, value = (part.strip() for part in text.partition("="))
        name = name.removesuffix("'").rstrip()
        if not (name and sign and value):
            raise argparse.ArgumentTypeError(
                f'must be NAME=VALUE; got {text!r}; write {flag} "{example}"'
            )
        return name, value

    return read


def pairs(flag: str, example: str) -> Callable[[str], tuple[tuple[str, str], ...]]:
    """Return a reader of ``name = text`` pairs, separated by commas."""
    read_pair = pair(flag, example)

    def read(text: str) -> tuple[tuple[str, str], ...]:
        found = tuple(read_pair(part) for part in text.split(","))
        if len(dict(found)) < len(found):
            raise argparse.ArgumentTypeError(f"must name each of them once; got {text!r}")
        return found

    return read


def constants(text: str) -> tuple[tuple[str, float], ...]:
    """Read ``name=number`` pairs, separated by commas."""
    found = pairs("--known", "m=1.2,g=9.81")(text)
    try:
        return tuple((name, float(value)) for name, value in found)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"must have numbers as values; got {text!r}") from error


def turn(text: str) -> tuple[str, float]:
    """Read ``name=number``: an angle and the size of its full turn."""
    name, value = pair("--unwrap", "phi=360")(text)
    try:
        size = float(value)
    except ValueError:
        size = math.nan
    if not 0.0 < size < math.inf:
        raise argparse.ArgumentTypeError(
            f"must have a turn above zero; got {text!r}; write 360 for degrees, 6.283185 for "
            "radians, or the counts of a turn"
        )
    return name, size


def cutoff(text: str) -> str | float | None:
    """Read a frequency, auto or none."""
    if text in ("auto", "none"):
        return None if text == "none" else text
    try:
        return float(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"must be auto, none or a number; got {text!r}") from error


def folder(text: str) -> Path:
    """Read the name of a folder, which need not exist yet."""
    path = Path(text)
    taken = next((parent for parent in (path, *path.parents) if parent.is_file()), None)
    if taken is not None:
        raise argparse.ArgumentTypeError(f"must be a folder; got the file {str(taken)!r}")
    return path


def count(least: int) -> Callable[[str], int]:
    """Return a reader of integers of at least `least`."""

    def read(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(
                f"must be an integer of at least {least}; got {text!r}"
            )
        return int(text)

    return read
