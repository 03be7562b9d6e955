"""A record and the equations found in it, for the figures."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..datasets import DuffingRig
from ..equations import Equations
from .cases import Case
from .trials import identify

__all__ = ["Identified"]


class Identified:
    """A record and the equations found in it, each computed when it is first used."""

    def __init__(self, case: Case) -> None:
        self.case = case

    @cached_property
    def rig(self) -> DuffingRig:
        """The record."""
        return self.case.simulate()

    @cached_property
    def equations(self) -> Equations:
        """The identified equations."""
        return identify(self.case)[0]

    @cached_property
    def predicted(self) -> np.ndarray:
        """Identified acceleration on the validation part, (n,)."""
        at = self.rig.validation
        return self.equations.evaluate(self.rig.x[at], self.rig.u[at])[:, -1]
