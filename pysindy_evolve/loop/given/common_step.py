"""One sampling time for records whose raw ones differ: a multiple of each of them."""

from __future__ import annotations

from collections.abc import Sequence

from ...signals.prepare import LEAST_OVERSAMPLING

__all__ = ["TOLERANCE", "common_step"]

TOLERANCE = 0.01  # relative error of a multiple, as clocks are not exact
COARSER = 2.0  # largest common step over the one wanted; a coarser one is the user's choice
MULTIPLES = 4  # multiples of the longest raw sampling time that are searched at least


def common_step(raw: Sequence[float], wanted: float, cutoff: float | None) -> float:
    """Return a step near the one wanted that is a multiple of every raw sampling time.

    It is the longest one up to the step wanted or, if there is none, the shortest one beyond.

    Parameters
    ----------
    raw : sequence of float
        Raw sampling times of all records, units of t.
    wanted : float
        Step that the training records alone would have, units of t.
    cutoff : float or None
        Of the training records, cycles per unit of t; without one, nothing may be left out.

    Returns
    -------
    float
        Units of t.

    Raises
    ------
    ValueError
        If there is none up to twice the step wanted, or only one at which signals would alias.
    """
    longest, limit = max(raw), COARSER * wanted * (1.0 + TOLERANCE)
    multiples = [k * longest for k in range(1, max(MULTIPLES, int(limit / longest)) + 1)]
    shared = [step for step in multiples if all(_goes_into(one, step) for one in raw)]
    fits = [step for step in shared if all(_keeps(one, step, cutoff) for one in raw)]
    shorter = [step for step in fits if step <= wanted * (1.0 + TOLERANCE)]
    if shorter:
        return shorter[-1]
    if fits and fits[0] <= limit:
        return fits[0]
    times = " and ".join(f"{one:g}" for one in sorted({float(f"{one:.4g}") for one in raw}))
    band = "without cutoff" if cutoff is None else f"with a cutoff of {cutoff:.4g}"
    raise ValueError(
        "close_loop(train=..., test=...) must have raw sampling times that go into one step, near "
        f"the {wanted:g} of the training records; got {times}, {band}. {_advice(fits or shared)}"
    )


def _goes_into(raw: float, step: float) -> bool:
    """Tell whether a step is a multiple of a raw sampling time."""
    return abs(max(1, round(step / raw)) * raw / step - 1.0) <= TOLERANCE


def _keeps(raw: float, step: float, cutoff: float | None) -> bool:
    """Tell whether `prepare` can decimate to a step, with this cutoff, without aliasing."""
    factor = round(step / raw)
    if cutoff is None:
        return factor == 1
    most = max(1, int(1.0 / (LEAST_OVERSAMPLING * cutoff * raw)))
    return 2.0 * cutoff * raw < 1.0 and factor <= most


def _advice(steps: Sequence[float]) -> str:
    """Return how to make the shortest of some common steps possible, or what to do without one."""
    if not steps:
        return "Bring all records to one step with signals.resample."
    band = 1.0 / (LEAST_OVERSAMPLING * steps[0])
    return (
        f"Prepare all of them to a step of {steps[0]:g}, by `decimate`, with a cutoff of at most "
        f"{band:.3g}, or bring the records to one step with signals.resample."
    )
