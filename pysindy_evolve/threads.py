"""One thread for the linear algebra, whatever the machine has.

The matrices are small, so more threads only slow each other down. The last digits of a result
depend on their number, and a search may turn on these digits. With one thread the same seed gives
the same result everywhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from threadpoolctl import ThreadpoolController


@contextmanager
def one_thread() -> Iterator[None]:
    """Use one thread of each BLAS inside this context; also a decorator, as ``@one_thread()``.

    It holds for the whole process. If several Python threads are inside at once, the last one to
    leave restores the limit that it found, which another one had set.
    """
    with _controller().limit(limits=1, user_api="blas"):
        yield


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()  # it looks through the loaded libraries, which takes a while
