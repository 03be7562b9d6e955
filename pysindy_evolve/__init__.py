"""Give it your model and your measurements; it grows the PySINDy terms your model is missing,
proves them on data it has not seen, and hands back the corrected equation.
"""

from pysindy_evolve import datasets, signals
from pysindy_evolve.export import plot_tree, to_callable, to_code, to_latex, to_sympy
from pysindy_evolve.library import EvolvingLibrary
from pysindy_evolve.loop import DeclaredModel, Effect, LoopReport, close_loop
from pysindy_evolve.operators import Operator
from pysindy_evolve.optimizer import ElasticNet
from pysindy_evolve.signals import Record, prepare
from pysindy_evolve.simulation import simulate

__version__ = "0.1.0"

__all__ = [
    "DeclaredModel",
    "Effect",
    "ElasticNet",
    "EvolvingLibrary",
    "LoopReport",
    "Operator",
    "Record",
    "close_loop",
    "datasets",
    "plot_tree",
    "prepare",
    "signals",
    "simulate",
    "to_callable",
    "to_code",
    "to_latex",
    "to_sympy",
]
