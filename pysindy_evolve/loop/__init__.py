"""The loop: declared model and measurement in, corrected equation and its evidence out."""

from .close import close_loop
from .declared import DeclaredModel
from .report import Effect, LoopReport

__all__ = ["DeclaredModel", "Effect", "LoopReport", "close_loop"]
