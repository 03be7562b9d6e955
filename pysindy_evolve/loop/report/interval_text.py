"""Numbers with the intervals in which they lie, with as many digits as tell their ends apart."""

from __future__ import annotations

import numpy as np

from ...export import format_number

__all__ = ["ends", "interval", "value_within"]


def interval(low: float, high: float) -> str:
    """Return a 95 % interval with enough digits to tell its ends apart."""
    return f"(95 %: {ends(low, high)})"


def value_within(value: float, low: float, high: float) -> str:
    """Return a number, with as many digits as its interval where fewer round it out of that."""
    shown = format_number(value)
    is_out = low <= value <= high and not low <= float(f"{value:.4g}") <= high
    return format_number(value, _digits(low, high)) if is_out else shown


def ends(low: float, high: float) -> str:
    """Return the ends of an interval, with zeros at the end of one where the other has digits."""
    digits = _digits(low, high)
    shown = [f"{end:#.{digits}g}" if end else "0" for end in (low, high)]
    if any("e" in end for end in shown):
        return f"{low:.{digits}g} to {high:.{digits}g}"
    while all("." in end and end[-1] in "0." for end in shown):
        shown = [end[:-1] for end in shown]
    return " to ".join(end.removesuffix(".") for end in shown)


def _digits(low: float, high: float) -> int:
    size, width = max(abs(low), abs(high)), high - low
    usable = np.isfinite(size) and np.isfinite(width) and width > 0.0
    needed = 2 + int(np.ceil(np.log10(size / width))) if usable else 4
    return min(max(needed, 4), 12)
