"""Names in a text: constants that must have a value, and what an unknown name was meant to be."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from difflib import get_close_matches
from numbers import Real
from typing import Any

__all__ = ["advise_function", "advise_parameter", "check_known"]

PRODUCT = 2  # letters of a name that may have been a factor: k(q - 1) was meant as k*(q - 1)


def check_known(known: Mapping[str, Any], call: str) -> dict[str, float]:
    """Return known constants as floats; raise, naming the constant, where one is no number."""
    for name, value in known.items():
        if not isinstance(value, Real) or not math.isfinite(value):
            raise ValueError(
                f"{call}(known[{name!r}]=...) must be a finite number; got {value!r}. "
                f"Give a number, or leave {name} free."
            )
    return {name: float(value) for name, value in known.items()}


def advise_function(name: str, functions: Iterable[str]) -> str:
    """Return what to write in the place of a call of an unknown function."""
    names = list(functions)
    near = get_close_matches(name, names, 2)
    said = f"Did you mean {' or '.join(near)}? " if near else ""
    if not near and len(name) <= PRODUCT:
        said = f"Write {name}*(...) for a product. "
    return f"{said}Functions: {', '.join(names)}."


def advise_parameter(
    names: Collection[str], variables: Iterable[str], inputs: Iterable[str]
) -> str:
    """Return what one of the free parameters was meant to be: the one most like a variable."""
    acting = list(inputs)
    states = [name for name in variables if name not in (*acting, "t")]
    near = {name: get_close_matches(name, [*states, *acting], 1, 0.7) for name in names}
    name = max(names, key=lambda one: bool(near[one]))  # the first, if none is like a variable
    meant = f" Did you mean {near[name][0]!r}?" if near[name] else ""
    return (
        f"{name!r} is neither a state ({', '.join(states) or 'none'}) nor an input "
        f"({', '.join(acting) or 'none'}), so it was read as a free parameter.{meant} If it is an "
        "input, name it in `inputs`; if it is a constant, give it in `known`, or name the whole "
        "factor as one parameter."
    )
