"""Give it your model and your measurements; it grows the PySINDy terms your model is missing,
proves them on data it has not seen, and hands back the corrected equation.

To correct a model that you have, begin with `loop`; to grow terms in `ps.SINDy`, with `library`.

================  ========================================================================
what users call
loop              a declared model, corrected from records: `close_loop`
library           EvolvingLibrary, a PySINDy feature library that grows its terms
term_library      TermLibrary, a PySINDy feature library of given terms
optimizer         ElasticNet, an optimizer for `ps.SINDy`
signals           raw measurements turned into records: states, derivatives, inputs
simulation        integration of equations that stick and slip
export            equations as text, LaTeX, sympy, code, functions and pictures
datasets          simulated rigs and measured records to try the package on
cli               the command line
__main__          makes `python -m pysindy_evolve` run the command line
paper             the tables and figures of the paper, computed again
terms, equations
operators         basis functions, each with its numpy form and its sympy form
terms             products and sums as immutable trees, each in one canonical form
equations         terms with coefficients and names: what is scored, printed and simulated
substitution      replaces variables of an expression by other expressions
reading           reads terms from text, from names and from PySINDy models
hidden_states     terms and inputs with memory: delays, lags, hysteresis, relaxation
growing terms
evolution         Algorithm 1 of the paper, the loop over generations
breeding          the steps of one generation
sparse            selection of the few terms that an equation needs
handover          how the library gets x_dot, which `ps.SINDy` does not pass to it
training          checks of the data that terms are grown on
helpers
checks            checks of arguments, and the form of all error messages
lazily            a cached property for small immutable objects
threads           linear algebra on one thread, so that results repeat exactly
warn              warnings that point at the line of the user
================  ========================================================================
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
