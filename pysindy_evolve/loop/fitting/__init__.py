"""Coefficients fitted to derivatives, trajectories and free runs."""
