"""Tests of pysindy_evolve.signals."""
