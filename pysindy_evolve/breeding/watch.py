"""Run a search with a progress bar until it stagnates, completes or is interrupted."""

from __future__ import annotations

from collections.abc import Iterable

from tqdm.auto import tqdm

from ..terms import Product
from ..warn import warn
from .generation import Generation
from .plateau import Plateau


def watch(
    search: Iterable[tuple[Generation, tuple[Product, ...]]],
    plateau: Plateau,
    n_generations: int,
    progress: bool,
    keep_if_interrupted: bool,
) -> tuple[tuple[Generation, ...], tuple[Product, ...], bool]:
    """Run the generations of a search.

    Parameters
    ----------
    search : iterable of (Generation, tuple of Product)
        The generations, each with the finalists if it is the last.
    plateau : Plateau
        Tells when to stop.
    n_generations : int
        Largest number of generations, for the progress bar.
    progress : bool
        Whether to show a progress bar.
    keep_if_interrupted : bool
        Whether Ctrl-C ends the search with the best equation so far; otherwise it is raised.

    Returns
    -------
    history : tuple of Generation
        All generations that ran.
    finalists : tuple of Product
        The terms to weigh against each other on all rows.
    interrupted : bool
        Whether Ctrl-C ended the search.
    """
    history: list[Generation] = []
    finalists: tuple[Product, ...] = ()
    interrupted = False
    shown = tqdm(search, desc="generation", total=n_generations, disable=not progress)
    try:
        for generation, ranking in shown:
            history.append(generation)
            finalists = ranking
            shown.set_postfix(n_terms=generation.n_terms, error=f"{generation.error:.3g}")
            if plateau.reached(generation):
                break
    except KeyboardInterrupt:
        if not keep_if_interrupted:
            raise
        interrupted = True
        warn(
            f"EvolvingLibrary.fit was interrupted after {len(history)} generations; the best "
            "equation so far is kept. Fit again to let the search end by itself."
        )
    finally:
        shown.close()
    return tuple(history), finalists, interrupted
