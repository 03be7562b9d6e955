"""Simulates equations that stick and slip: one run in `simulate`, many short ones in `pieces`.

=========  =======================================================================
equations
structure  the terms of equations, where they switch, and which numbers may change
one run
simulate   `simulate`, which runs a model from one initial state
inputs     checks of times, initial states and inputs
freerun    integrates sample by sample, and locates each switch, stick and slip
limits     limits of a run, and how it ends where it exceeds one
program    one integration step, compiled into one Python function
filippov   Filippov's rule: the right-hand side while a switch stays at zero
rows       right-hand sides and switching functions as sympy expressions
scalars    sympy expressions compiled into scalar functions
many runs
pieces     several models over many pieces of records
columns    right-hand sides of many runs in one array
crossing   steps of many runs that cross a switch
tape       terms evaluated for many runs at once, without compilation
=========  =======================================================================
"""

from .simulate import simulate

__all__ = ["simulate"]
