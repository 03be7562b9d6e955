"""Simulated machines that lack an effect, none of them integrated by the package itself."""
