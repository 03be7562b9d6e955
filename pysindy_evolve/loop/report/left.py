"""What a model leaves of the measured derivative of a record."""

from __future__ import annotations

import numpy as np

from ...equations import Equations
from ...hidden_states.hidden import MemoryEquations
from ...hidden_states.memory import remembered
from ...signals import Record
from ..fitting.past import rates_on
from ..given.sensor import as_observed

__all__ = ["residual_of"]


def residual_of(equations: Equations, record: Record) -> np.ndarray:
    """Return x_dot minus the model, (n_samples, n_states); zero where no sensor saw the state."""
    if isinstance(equations, MemoryEquations):
        record, equations = remembered(record, equations.memories), equations.inner
    return as_observed(record, record.x_dot - rates_on(equations, record))
