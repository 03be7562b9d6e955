"""Measured sets for judging a model on a real thing, and simulated rigs with a known truth."""

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
