"""plot_tree: the equation of one state as a picture."""

from __future__ import annotations

from typing import Any

from .symbolic import system_of
from .tree import Node, expression_tree


def plot_tree(model: Any, state: str | None = None, ax: Any = None, digits: int | None = 4) -> Any:
    """Draw the equation of one state as a tree.

    Parameters
    ----------
    model : pysindy.SINDy, Equations or LoopReport
        Fitted model, or an object that holds one.
    state : str, optional
        Name of the state; by default the last one, where the dynamics of a mechanical system are.
    ax : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure of a size that fits the tree.
    digits : int or None
        Significant digits of the numbers.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ValueError
        If `state` is not a state of the model.
    ImportError
        If matplotlib is not installed.
    """
    system = system_of(model, "plot_tree", digits)
    name = system.lefts[-1] if state is None else state
    if name not in system.lefts:
        raise ValueError(
            f"plot_tree(state=...) must be a state of the model; got {state!r}. "
            f"Choose from {', '.join(system.lefts)}."
        )
    try:
        from .drawing import draw
    except ImportError as error:
        raise ImportError(
            "plot_tree needs matplotlib; got an environment without it. "
            'Run pip install "pysindy-evolve[plots]".'
        ) from error
    place = system.lefts.index(name)
    left = f"{name}′" if system.are_rates[place] else name
    return draw(Node(f"{left} =", "left", (expression_tree(system, place, digits),)), ax)
