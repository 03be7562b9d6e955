"""Numbers and their intervals as text, with enough digits to tell the ends of an interval apart."""

from __future__ import annotations

import numpy as np

from ...export import format_number

__all__ = ["ends", "interval", "value_within"]


def interval(low: float, high: float) -> str:
    """Return a 95 % interval with enough digits to tell its ends apart."""
    return f"(95 %: {ends(low, high)})"


def value_within(value: float, low: float, high: float) -> str:
    """Return a number in four digits; in as many as its interval if four round it out of that."""
    text = format_number(value)
    leaves_interval = low <= value <= high and not low <= float(f"{value:.4g}") <= high
    return format_number(value, _digits(low, high)) if leaves_interval else text


def ends(low: float, high: float) -> str:
    """Return the ends of an interval with as many digits as tell them apart.

    Zeros at the end are cut only if both have them.
    """
    digits = _digits(low, high)
    texts = [f"{end:#.{digits}g}" if end else "0" for end in (low, high)]
    if any("e" in end for end in texts):
        return " to ".join(format_number(end, digits) for end in (low, high))
    while all("." in end and end[-1] in "0." for end in texts):
        texts = [end[:-1] for end in texts]
    return " to ".join(end.removesuffix(".") for end in texts)


def _digits(low: float, high: float) -> int:
    """Return the significant digits, 4 to 12, that resolve an interval to a hundredth or so."""
    size, width = max(abs(low), abs(high)), high - low
    usable = np.isfinite(size) and np.isfinite(width) and width > 0.0
    needed = 2 + int(np.ceil(np.log10(size / width))) if usable else 4
    return min(max(needed, 4), 12)
