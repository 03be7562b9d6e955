"""What the loop came to, as data: equations, errors, effects, and the records behind them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...equations import Equations
from ...signals import Record
from ..evidence.rejected import Rejected
from ..given.design import Design
from ..given.rules import Rules
from .effect import Effect, Errors, Step
from .residuals import residual_of


@dataclass(frozen=True, eq=False)
class Outcome:
    """The effects that a declared model lacks, and the errors without and with them.

    `LoopReport` is an outcome that prints, draws and simulates itself, and says what each field
    means. What decides or tells something takes an outcome, and need not know the report.
    """

    verdict: str
    effects: list[Effect]
    before: Errors
    after: Errors
    steps: list[Step]
    train: tuple[Record, ...]
    test: tuple[Record, ...]
    finished: bool
    rules: Rules
    design: Design
    rejected: Rejected | None = None
    chance_left: float = 1.0
    found_held: tuple[int, ...] = ()
    shows_motion: bool = True
    interrupted: bool = False

    @property
    def equations(self) -> Equations:
        """The corrected model."""
        return self.after.model

    @property
    def leaves_structure(self) -> bool:
        """Whether the residual of the corrected model still has structure, beside the effects."""
        return self.verdict == "traced" and self.chance_left <= self.rules.level

    @property
    def residual_before(self) -> list[np.ndarray]:
        """x_dot minus the declared model, for each held-out record; zero on rows not `seen`."""
        return [residual_of(self.before.model, record) for record in self.test]

    @property
    def residual_after(self) -> list[np.ndarray]:
        """x_dot minus the corrected model, for each held-out record; zero on rows not `seen`."""
        return [residual_of(self.after.model, record) for record in self.test]
