"""Effects of which the final fit does not say that they are there.

That something is missing was tested where an effect came in. With all others beside it, and refined
by the runs, nothing may be left of it; an effect whose own interval contains zero is withdrawn, and
a vessel if that of its brim does. Not so what remembers a motion: free runs have asked for it, and
its value is hardly known apart from that of the friction beside it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..evidence.findings import Finding, MemoryFinding, is_needed
from ..facts.effect import Effect
from ..given.design import Design


def most_doubtful(
    findings: Sequence[Finding], effects: Sequence[Effect], design: Design
) -> Finding | None:
    """Return the finding that is least sure to differ from zero.

    Parameters
    ----------
    findings : sequence of Finding
        What was found.
    effects : sequence of Effect
        The same with their coefficients and 95 % intervals.
    design : Design
        The model with all of them.

    Returns
    -------
    Finding or None
        None if each has a coefficient, a time or a brim whose interval does not contain zero, has
        none, remembers, or is needed beside another.
    """
    doubts = {
        k: _ratio(effect, _telling(finding))
        for k, (finding, effect) in enumerate(zip(findings, effects, strict=True))
        if (finding.columns or isinstance(finding, MemoryFinding))
        and not is_needed(finding, findings)
        and not _remembers(finding, design)
    }
    worst = min(doubts, key=lambda k: doubts[k], default=None)
    return findings[worst] if worst is not None and doubts[worst] < 1.0 else None


def _telling(finding: Finding) -> slice:
    """Return which numbers say whether an effect is there: of a vessel, its brim does."""
    overflows = isinstance(finding, MemoryFinding) and finding.memory.has_brim
    return slice(1, 2) if overflows else slice(None)


def _remembers(finding: Finding, design: Design) -> bool:
    return len(design.dropping(finding.columns).paths) < len(design.paths)


def _ratio(effect: Effect, telling: slice) -> float:
    """Return how many times an interval's reach towards zero the surest of its numbers is."""
    values, ends = effect.coefficients[telling], effect.confidence_intervals[telling]
    towards = np.abs(values - np.where(values > 0.0, ends[:, 0], ends[:, 1]))
    with np.errstate(divide="ignore", invalid="ignore"):
        # Where an interval ends at zero, it is that of a time or a brim.
        ratios = np.where(ends[:, 0] == 0.0, 0.0, np.abs(values) / towards)
    return float(np.max(np.nan_to_num(ratios, nan=np.inf), initial=0.0))
