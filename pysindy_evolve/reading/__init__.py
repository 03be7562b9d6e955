"""Reads terms from text, from sympy, from Python functions and from fitted PySINDy models.

`text.py` and `library_terms.py` are where to begin.

=============  ===============================================================
text           right-hand sides as text or sympy, read against a whitelist
grammar        from text or sympy to a syntax tree of arithmetic and calls
names          names in a text: constants, and what a misspelled name may mean
library_terms  a fitted PySINDy model, or the columns of its library
tracing        a Python function of arrays, called once on symbols
extremes       minimum and maximum of expressions, written with magnitudes
=============  ===============================================================
"""
