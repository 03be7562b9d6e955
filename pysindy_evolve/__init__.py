"""pysindy_evolve: give it your model and your measurements.

It grows the PySINDy terms your model is missing, proves them on data it has not seen, and hands
back the corrected equation.
"""

__version__ = "0.1.0"

__all__ = ["__version__"]
