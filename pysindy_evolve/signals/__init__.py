"""Measured signals: records, zero-phase filters, derivatives, windows, text files.

`prepare` turns raw positions into a `Record`; `project` averages both sides of an equation
over smooth windows before they are compared.
"""

from .files import read_csv
from .filters import Motion, differentiate, integrate, lowpass
from .fuse import fuse
from .noise import noise_level
from .preparation import Preparation
from .prepare import prepare
from .record import Record
from .sampling import resample
from .switches import is_decided
from .target import as_target
from .windows import Windows, choose_windows, project, project_derivative

__all__ = [
    "Motion",
    "Preparation",
    "Record",
    "Windows",
    "as_target",
    "choose_windows",
    "differentiate",
    "fuse",
    "integrate",
    "is_decided",
    "lowpass",
    "noise_level",
    "prepare",
    "project",
    "project_derivative",
    "read_csv",
    "resample",
]
