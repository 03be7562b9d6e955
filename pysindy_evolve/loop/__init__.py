"""The loop: declared model and measurement in, corrected equation and its evidence out."""

from .close import close_loop
from .given.declared import DeclaredModel
from .report.report import Effect, LoopReport

__all__ = ["DeclaredModel", "Effect", "LoopReport", "close_loop"]
