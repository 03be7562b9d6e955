"""A cached property for small immutable objects that are made by the hundred thousand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar, overload

Value = TypeVar("Value")


class lazily(Generic[Value]):
    """Compute an attribute when it is first asked for, and keep it in the object.

    ``functools.cached_property`` takes a lock around each first access before Python 3.12, and
    most attributes of a term are read only once or twice. Without the lock two threads may both
    compute the value, with the same result.

    Parameters
    ----------
    function : callable
        Maps the object to the value of the attribute.

    Examples
    --------
    >>> class Half:
    ...     @lazily
    ...     def size(self):
    ...         return 0.5
    >>> Half().size
    0.5
    """

    def __init__(self, function: Callable[[Any], Value]) -> None:
        self.function = function
        self.name = function.__name__
        self.__doc__ = function.__doc__

    @overload
    def __get__(self, owner: None, kind: type) -> lazily[Value]: ...
    @overload
    def __get__(self, owner: object, kind: type) -> Value: ...
    def __get__(self, owner: Any, kind: Any) -> Any:
        """Compute the value; afterwards the object's own dictionary answers first."""
        if owner is None:
            return self
        value = owner.__dict__[self.name] = self.function(owner)
        return value
