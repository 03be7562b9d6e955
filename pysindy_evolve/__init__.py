"""Give it your model and your measurements; it grows the PySINDy terms your model is missing,
proves them on data it has not seen, and hands back the corrected equation.
"""

from pysindy_evolve import datasets, signals
from pysindy_evolve.operators import Operator
from pysindy_evolve.signals import Record, prepare
from pysindy_evolve.simulation import simulate

__version__ = "0.1.0"

__all__ = [
    "Operator",
    "Record",
    "datasets",
    "prepare",
    "signals",
    "simulate",
]
