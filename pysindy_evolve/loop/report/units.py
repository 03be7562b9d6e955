"""Labels with the user's units; without them a name stands alone."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["check_units", "label", "percent", "rate_label", "with_unit"]

ROUND = 99.5  # percent, from which two digits would be written as 1e+02


def with_unit(value: float, name: str, units: Mapping[str, str] | None) -> str:
    """Return a number with the unit of a variable."""
    unit = (units or {}).get(name, "")
    return f"{value:.3g} {unit}".rstrip()


def percent(value: float) -> str:
    """Return a number of percent with two digits, and no power of ten below a million."""
    return f"{value:.0f} %" if ROUND <= value < 1e6 else f"{value:.2g} %"


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
