"""Tests of pysindy_evolve.simulation."""
