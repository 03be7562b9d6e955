"""Numbers as people read them: with intervals and the user's units, or in percent."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...export import format_number

ROUND = 99.5  # percent; from here on the format .2g would print 1e+02
TENFOLD = 999.5  # percent; from here on a factor is printed
LARGE = 1e6  # from here on a number is printed with a power of ten
MANY = 1e3  # larger factors are printed as "over 1000 times"


def with_unit(value: float, name: str, units: Mapping[str, str] | None) -> str:
    """Return a number with the unit of a variable."""
    unit, text = (units or {}).get(name, ""), f"{value:.3g}"
    if abs(value) < LARGE:
        text = f"{float(text):.0f}" if "e+" in text else text  # 2440 and not 2.44e+03
    return f"{text} {unit}".rstrip()


def percent(value: float) -> str:
    """Return percent of a standard deviation with two digits; from tenfold on, as a factor."""
    if value >= TENFOLD:
        return f"{_times(value)} the standard deviation"
    return f"{value:.0f} %" if value >= ROUND else f"{value:.2g} %"


def percent_cell(value: float) -> str:
    """Return the same for a table, whose head says of what; "diverges" if it is not finite."""
    if not np.isfinite(value):
        return "diverges"
    return _times(value) if value >= TENFOLD else f"{value:.3g}"


def _times(value: float) -> str:
    factor = value / 100.0
    return f"{factor:.0f} times" if factor < MANY else f"over {MANY:.0f} times"


def label(name: str, units: Mapping[str, str] | None) -> str:
    """Return the label of an axis."""
    unit = (units or {}).get(name, "")
    return f"{name} [{unit}]" if unit else name


def rate_label(name: str, units: Mapping[str, str] | None) -> str:
    """Return the label of the derivative of a state."""
    unit, time = ((units or {}).get(key, "") for key in (name, "t"))
    if not unit or not time:
        return f"d{name}/dt"
    over, under = unit, time
    if unit.endswith(f"/{time}"):
        over, under = unit.removesuffix(f"/{time}"), f"{time}²"
    return f"d{name}/dt [{over}/{under}]"


def check_units(owner: str, units: Mapping[str, str] | None, names: tuple[str, ...]) -> None:
    """Raise if units are given for something that is no variable."""
    for name in units or {}:
        if name not in names:
            raise ValueError(
                f"LoopReport.{owner}(units=...) must name variables of the model; got {name!r}. "
                f"Choose from {', '.join(names)}."
            )


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
