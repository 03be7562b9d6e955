"""The best of what did not pass: what the verdict "complete" rests on."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .trace import Score

__all__ = ["Rejected"]


@dataclass(frozen=True, eq=False)
class Rejected:
    """The best effect, or pair of effects, of a step that added nothing.

    Attributes
    ----------
    tried : Score
        The effect or pair, with its errors.
    share : float
        Share of the explainable error that it removes.
    p_value : float
        Chance that a twin shows a score as large; NaN if its share was too small to ask.
    twin_scores : ndarray
        Best score found in each twin.
    """

    tried: Score
    share: float
    p_value: float = np.nan
    twin_scores: np.ndarray = field(default_factory=lambda: np.empty(0))

    @property
    def name(self) -> str:
        """Names of its effects."""
        return ", ".join(candidate.name for candidate in self.tried.group)

    @property
    def score(self) -> float:
        """Log ratio of the errors without and with it, per effect of its group."""
        return self.tried.value
