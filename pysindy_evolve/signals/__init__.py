"""Measured signals: records, zero-phase filters, derivatives, windows, text files.

`prepare` turns raw positions into a `Record`; `project` averages both sides of an equation
over smooth windows before they are compared.

===============  ====================================================================
measured data
record           Record: states, derivatives and inputs at the same times
prepare          raw positions filtered and differentiated: a record
preparation      how a record was prepared, to be repeated for other data
target           records whose target is a force, to be explained by the motion
files            reads signals from text files
raw readings
sampling         uniform sampling times, and resampling where they are not uniform
wrapping         angles that jump after a whole turn
clipping         readings at the end of a sensor's range, and curves that bridge them
filtering
filters          low-pass, derivative and integral of one signal
lost_motion      a warning of a low-pass that leaves out most of the motion
spectral         the FFT filter behind `filters.py`
windows          smooth windows over the rows: the weak form
decided          rows on which the low-pass leaves the direction of motion certain
less noise
noise            noise level of a sensor, and the cutoff that follows from it
bands            bands of frequencies over which spectra are averaged
smoothing        states with less noise, estimated with the help of their derivatives
improved         where an estimate is nearer to the signal than its measurement
time_step        the sampling time of states, estimated from their derivatives
fuse             measured derivatives combined with the slopes of the states
wiener           the Wiener filter that combines measurements of a signal and its derivatives
inputs
zero_order_hold  inputs that a controller holds from sample to sample
acting           inputs that act through a function, such as the square of a speed
===============  ====================================================================
"""

from .decided import is_decided
from .files import read_csv
from .filters import Motion, differentiate, integrate, lowpass
from .fuse import fuse
from .noise import noise_level
from .preparation import Preparation
from .prepare import prepare
from .record import Record
from .sampling import resample
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
