"""Follow a search: a progress bar, an end where nothing comes any more, an interruption."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any

from tqdm.auto import tqdm

from ..terms import Product
from .generation import Generation
from .plateau import Plateau

__all__ = ["watch"]


def watch(
    search: Iterable[tuple[Generation, tuple[Product, ...]]],
    plateau: Plateau,
    keep_if_interrupted: bool,
    **bar: Any,
) -> tuple[tuple[Generation, ...], tuple[Product, ...]]:
    """Go through the generations of a search.

    Parameters
    ----------
    search : iterable of (Generation, tuple of Product)
        The generations, each with the terms to weigh if it is the last.
    plateau : Plateau
        Tells which one is the last.
    keep_if_interrupted : bool
        Whether Ctrl-C ends the search with what there is, or is passed on.
    **bar
        For the progress bar.

    Returns
    -------
    history : tuple of Generation
        All generations.
    finalists : tuple of Product
        The terms to weigh.
    """
    history: list[Generation] = []
    finalists: tuple[Product, ...] = ()
    shown = tqdm(search, desc="generation", **bar)
    try:
        for generation, ranking in shown:
            history.append(generation)
            finalists = ranking
            shown.set_postfix(n_terms=generation.n_terms, fitness=f"{generation.fitness:.3g}")
            if plateau.reached(generation):
                break
    except KeyboardInterrupt:
        if not keep_if_interrupted:
            raise
        warnings.warn(
            f"The search was interrupted after {len(history)} generations; "
            "the best equation so far is kept.",
            stacklevel=3,
        )
    finally:
        shown.close()
    return tuple(history), finalists
