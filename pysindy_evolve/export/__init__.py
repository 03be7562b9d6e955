"""Views of a model: sympy, text, LaTeX, code, a function of arrays, a picture of the tree.

All of them are made from `Equations`, so they show what is predicted and simulated. `symbolic.py`
is where to begin: the other views start from its sympy expressions.

=======================  ====================================================================
views
symbolic                 sympy expressions
printing                 plain text, such as v' = -691.9 q - 1.1 v
latex                    LaTeX
mathml                   MathML, which browsers display without scripts
callables                a function of arrays
code                     functions in Python, C, MATLAB, Julia and Modelica
code_printers            how each of these languages writes one expression
plotting                 `plot_tree`, the equation of one state as a picture
the tree of an equation
tree                     sums, products and calls as nodes
drawing                  layout of the nodes on a page; the only file that imports matplotlib
readable forms
compact                  rewrites sums as people write them; uses the file below
hinges                   stops and saturations as max(q - c, 0) and min(max(u, -c), c)
=======================  ====================================================================
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
