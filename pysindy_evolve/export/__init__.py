"""Views of a model: sympy, text, LaTeX, code, a function of arrays, a picture of the tree.

All of them are made from `Equations`, so they show what is predicted and simulated.
"""

from .callables import RightHandSideFunction, to_callable
from .code import to_code
from .latex import to_latex
from .plotting import plot_tree
from .printing import format_equations, format_expression, format_number
from .symbolic import to_sympy

__all__ = [
    "RightHandSideFunction", "format_equations", "format_expression", "format_number",
    "plot_tree", "to_callable", "to_code", "to_latex", "to_sympy",
]  # fmt: skip
