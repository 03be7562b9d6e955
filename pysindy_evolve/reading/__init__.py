"""What others wrote, as terms: text, sympy, functions of arrays, fitted PySINDy models."""
