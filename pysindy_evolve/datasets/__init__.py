"""Measured sets to test a model on, and simulated rigs with a known truth.

========  ==================================================================
measured  records measured on real hardware, one file for each set
odebench  63 differential equations of textbooks, with their truth
drives    a simulated linear axis with dry friction, or with nothing missing
rigs      the simulated Duffing rigs of the paper
sources   where the files come from: a folder, or a checked download
========  ==================================================================
"""

from .drives import Drive, friction_drive, nothing_missing
from .measured import (
    MeasuredRecord,
    MeasuredSet,
    load_ball_drops,
    load_cart,
    load_cascaded_tanks,
    load_emps,
    load_mr_damper,
    load_pendulum,
    load_silverbox,
    load_tclab,
)
from .odebench import OdeSystem, load_odebench
from .rigs import DuffingRig, duffing

__all__ = [
    "Drive",
    "DuffingRig",
    "MeasuredRecord",
    "MeasuredSet",
    "OdeSystem",
    "duffing",
    "friction_drive",
    "load_ball_drops",
    "load_cart",
    "load_cascaded_tanks",
    "load_emps",
    "load_mr_damper",
    "load_odebench",
    "load_pendulum",
    "load_silverbox",
    "load_tclab",
    "nothing_missing",
]
