"""Split of the given records: those to fit on and those to judge on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...signals import Record

HELD_OUT = 0.3  # share of a single record that is held out


def split_records(
    train: Record | Sequence[Record], test: Record | Sequence[Record] | None
) -> tuple[list[Record], list[Record]]:
    """Return the records to fit on and those to judge on.

    Raises
    ------
    TypeError
        If something is neither a Record nor a list of them.
    ValueError
        If a list is empty, or the one record is too short to hold anything out.
    """
    fit_on, judge_on = _listed("train", train), [] if test is None else _listed("test", test)
    if judge_on:
        return fit_on, judge_on
    if len(fit_on) > 1:
        return fit_on[:-1], fit_on[-1:]
    first, last = fit_on[0].split(HELD_OUT)
    return [first], [last]


def _listed(parameter: str, given: Any) -> list[Record]:
    records = [given] if isinstance(given, Record) else given
    if not isinstance(records, list | tuple) or not all(isinstance(r, Record) for r in records):
        raise TypeError(
            f"close_loop({parameter}=...) must be a Record or a list of them; "
            f"got {type(given).__name__}. Make one with prepare(t, q, F)."
        )
    if not records:
        raise ValueError(
            f"close_loop({parameter}=...) must hold at least one record; got an empty list. "
            "Make one with prepare(t, q, F)."
        )
    return list(records)
