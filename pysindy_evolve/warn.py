"""Warnings that point at the line of the user, however many calls of libraries lie between."""

from __future__ import annotations

import sys
import warnings

# Packages whose lines no user wrote, and the module of context managers used as decorators.
LIBRARIES = ("pysindy_evolve", "pysindy", "sklearn", "joblib", "contextlib")


def warn(message: str, category: type[Warning] = UserWarning) -> None:
    """Warn at the first line outside of the libraries.

    Parameters
    ----------
    message : str
        Which call, what it found, and what to do.
    category : type, default UserWarning
        Kind of warning, to filter by.
    """
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and _is_of_library(frame.f_globals.get("__name__", "")):
        frame, level = frame.f_back, level + 1
    warnings.warn(message, category, stacklevel=level)


def _is_of_library(module: str) -> bool:
    return module.partition(".")[0] in LIBRARIES
