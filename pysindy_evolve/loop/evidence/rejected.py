"""The best candidate that did not pass, on which the verdict "complete" rests."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .ranking import Score


@dataclass(frozen=True, eq=False, repr=False)
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
    variables : tuple of str
        Names of states, inputs and time.
    level : float
        Largest p-value that would have counted in that look.
    """

    tried: Score
    share: float
    p_value: float = np.nan
    twin_scores: np.ndarray = field(default_factory=lambda: np.empty(0))
    variables: tuple[str, ...] = ()
    level: float = np.nan

    def __repr__(self) -> str:
        tried = ", ".join(
            f"{one.name} in {self.variables[one.state]}: "
            + ", ".join(term.name(self.variables) for term in one.terms)
            for one in self.tried.group
        )
        figures = f"share={self.share:.2g}, score={self.score:.2g}, p_value={self.p_value:.2g}"
        return f"Rejected({tried}; {figures}, {len(self.twin_scores)} twins)"

    @property
    def name(self) -> str:
        """Names of its effects."""
        return ", ".join(candidate.name for candidate in self.tried.group)

    @property
    def score(self) -> float:
        """Log ratio of the errors without and with it, per effect of its group."""
        return self.tried.value
