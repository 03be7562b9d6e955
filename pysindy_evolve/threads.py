"""One thread for the linear algebra, whatever the machine has.

The matrices are small, so threads only get in each other's way; and the last digits depend on
their number, on which a search may turn. So the same seed gives the same result everywhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from threadpoolctl import ThreadpoolController

__all__ = ["one_thread"]


@contextmanager
def one_thread() -> Iterator[None]:
    """Do with one thread of each BLAS what is inside; also a decorator, as ``@one_thread()``.

    It holds for the whole process. Where several Python threads are inside at a time, the last one
    to leave restores what it found, which is the limit of another one.
    """
    with _controller().limit(limits=1, user_api="blas"):
        yield


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()  # it looks through the loaded libraries, which takes a while
