"""Terms: what a column of the library is made of.

A *term* is a product of integer powers of atoms; a *sum* is a linear combination of terms; an
*atom* is a variable, an operator applied to sums, or a sum. ::

    Product   q^2 sgn(v)          ((q, 2), (sgn(v), 1))
    Sum       0.5 + q             ((0.5, ONE), (1.0, q))
    Call      sin(2.1 q + 0.3)    (sin, (Sum,))
    Variable  q                   column 0

Arithmetic on sums multiplies out and collects, so every expression has one form: q*(q*q) and
cube(q) are the same term, and v*sgn(v) is abs(v). All classes are immutable, hash and pickle.
Floats inside an atom (the 2.1 and 0.3 above) are the *inner constants* of a term.

==========  ===================================================================
classes
node        base of all classes: hash, order and pickling
atoms       Variable and Call
products    Product
sums        Sum
operations
arithmetic  sums added, multiplied, divided and raised to a power
calls       operators applied to sums
canonical   canonical form of a product: powers collected, sgn and abs simplified
lowest      fractions in lowest terms
==========  ===================================================================
"""

from .arithmetic import add, constant, div, mul, neg, power, sub, variable
from .atoms import Call, Variable
from .calls import call
from .canonical import simplified
from .lowest import lowest
from .node import Cache
from .products import ONE, Product
from .sums import (
    Atom,
    Sum,
    as_product,
    as_sum,
    join_terms,
    of_term,
    only_atom,
    only_term,
    signed,
    value_of,
)

__all__ = [
    "ONE", "Atom", "Cache", "Call", "Product", "Sum", "Variable",
    "add", "as_product", "as_sum", "call", "constant", "div", "join_terms", "lowest", "mul",
    "neg", "of_term", "only_atom", "only_term", "power", "signed", "simplified", "sub",
    "value_of", "variable",
]  # fmt: skip
