"""Loaders of records measured on real hardware, each split into records to fit and to judge on.

Every loader takes ``folder``, the folder that holds one subfolder per set; None searches this
machine and then downloads, see `pysindy_evolve.datasets.sources.read_columns`. Records are raw:
nothing is filtered, and only the mean of an input is removed where the loader says so.

==============  ======================================================================
loaders
ball_drops      balls of several kinds, dropped from a bridge
cart            a cart under proportional control
cascaded_tanks  two tanks, the upper one draining into the lower one
emps            an electro-mechanical positioning system: a motor drives a linear axis
mr_damper       a magnetorheological damper
pendulum        a pendulum in free swing
silverbox       an electronic circuit that behaves as a Duffing oscillator
tclab           a board with heaters and temperature sensors
result
record          what each loader returns: records to fit on, records to judge on
==============  ======================================================================
"""

from .ball_drops import load_ball_drops
from .cart import load_cart
from .cascaded_tanks import load_cascaded_tanks
from .emps import load_emps
from .mr_damper import load_mr_damper
from .pendulum import load_pendulum
from .record import MeasuredRecord, MeasuredSet
from .silverbox import load_silverbox
from .tclab import load_tclab

__all__ = [
    "MeasuredRecord",
    "MeasuredSet",
    "load_ball_drops",
    "load_cart",
    "load_cascaded_tanks",
    "load_emps",
    "load_mr_damper",
    "load_pendulum",
    "load_silverbox",
    "load_tclab",
]
