"""Names in a text: known constants are checked, and errors suggest what an unknown name means."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from difflib import get_close_matches
from numbers import Real
from typing import Any

NUMERALS = re.compile(r"\d+")
ALIKE = 0.66  # least similarity of two names: one letter of three differs, or two have one more
SPEEDS = ("v", "w", "omega", "vel", "velocity", "speed", "dq", "qd", "q_dot", "dx", "xd", "x_dot")
PRODUCT = 2  # letters up to which a name may be a factor: k(q - 1) was meant as k*(q - 1)


def check_known(known: Mapping[str, Any], call: str) -> dict[str, float]:
    """Return known constants as floats; raise if one is not a finite number."""
    for name, value in known.items():
        if not isinstance(value, Real) or not math.isfinite(value):
            raise ValueError(
                f"{call}(known[{name!r}]=...) must be a finite number; got {value!r}. "
                f"Give a number, or leave {name} free."
            )
    return {name: float(value) for name, value in known.items()}


def advise_function(name: str, functions: Iterable[str]) -> str:
    """Return the advice for a call of an unknown function."""
    names = list(functions)
    near = get_close_matches(name, names, 2)
    guess = f"Did you mean {' or '.join(near)}? " if near else ""
    if not near and len(name) <= PRODUCT:
        guess = f"Write {name}*(...) for a product. "
    return f"{guess}Functions: {', '.join(names)}."


def advise_parameter(
    names: Collection[str],
    variables: Iterable[str],
    inputs: Iterable[str],
    known: Iterable[str] = (),
) -> str:
    """Return the advice for free parameters of which one may be a misspelled name.

    If several are factors of a product and none resembles a known name, one may be a speed under
    another of its usual names.
    """
    acting = list(inputs)
    states = [name for name in variables if name not in (*acting, "t")]
    near = {name: _meant(name, [*states, *acting, *known]) for name in names}
    if len(names) > 1 and not any(near.values()):
        near = {name: _speed(name, states) for name in names}
    name = max(names, key=lambda name: bool(near[name]))  # the first, if none resembles a name
    meant = f" Did you mean {near[name]!r}?" if near[name] else ""
    return (
        f"{name!r} is neither a state ({', '.join(states) or 'none'}) nor an input "
        f"({', '.join(acting) or 'none'}), so it was read as a free parameter.{meant} If it is a "
        "state, give its equation; if it is an input, name it in `inputs`; if it is a constant, "
        "give it in `known`, or name the whole factor as one parameter."
    )


def _meant(name: str, others: Sequence[str]) -> str:
    """Return the name that differs by case only, else the most similar one; "" if there is none."""
    for other in others:
        if other.casefold() == name.casefold():
            return other
    # k12 is another parameter than k13, not a misspelled one.
    compared = [other for other in others if NUMERALS.sub("", other) != NUMERALS.sub("", name)]
    return next(iter(get_close_matches(name, compared, 1, ALIKE)), "")


def _speed(name: str, states: Sequence[str]) -> str:
    """Return the state whose name stands for a speed, if `name` does too; else ""."""
    return next((state for state in states if name in SPEEDS and state in SPEEDS), "")
