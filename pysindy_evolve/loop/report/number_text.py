"""Numbers and axis labels with the user's units, and percentages."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

__all__ = ["check_units", "label", "percent", "percent_cell", "rate_label", "with_unit"]

ROUND = 99.5  # percent; from here on the format .2g would print 1e+02
TENFOLD = 999.5  # percent; from here on a factor is printed
MANY = 1e3  # larger factors are printed as "over 1000 times"


def with_unit(value: float, name: str, units: Mapping[str, str] | None) -> str:
    """Return a number with the unit of a variable."""
    unit = (units or {}).get(name, "")
    return f"{value:.3g} {unit}".rstrip()


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
