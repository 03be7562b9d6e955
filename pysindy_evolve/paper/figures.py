"""The content of each figure; `plots` draws them.

Figures 4, 5 and 11 show the records, 8 and 12 the identified equation as a tree, 9 and 13 the
measured against the identified acceleration, 10 the accuracy over the noise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from ..export import plot_tree
from .cases import SNR_RIG, Case, Plan
from .facts import PARTS, TABLE_4
from .store import Store
from .trials import Identified


def draw(parts: Sequence[str], plan: Plan, store: Store, folder: Path) -> Iterator[Path]:
    """Draw figures into a folder, one after the other.

    Parameters
    ----------
    parts : sequence of str
        Names of figures; other parts are ignored.
    plan : Plan
        Seeds, of which the first one is drawn, and signal-to-noise ratios.
    store : Store
        Finished trials.
    folder : Path
        Folder of the PNG and PDF files.

    Yields
    ------
    Path
        The PNG file.

    Raises
    ------
    ImportError
        If matplotlib is not installed.
    """
    wanted = [part for part in PARTS if part in parts and part.startswith("figure")]
    if not wanted:
        return
    try:
        from . import plots
    except ImportError as error:
        raise ImportError(
            "reproduce(parts=...) must be without figures where matplotlib is missing; got "
            f'{wanted[0]!r}. Run pip install "pysindy-evolve[plots]".'
        ) from error
    numerical = Identified(Case("numerical", 20.0, plan.seeds[0], fused=True))
    rigs = {e: Identified(Case("rig", SNR_RIG, plan.seeds[0], e)) for e in TABLE_4}
    trials = {
        snr: store.of([c for c in plan.for_figure10() if c.snr_db == snr]) for snr in plan.figure10
    }
    drawers: dict[str, Callable[[], Any]] = {
        "figure4": lambda: plots.input_and_output(numerical.rig),
        "figure5": lambda: plots.phase_plane(numerical.rig),
        "figure8": lambda: plot_tree(numerical.equations, "v").figure,
        "figure9": lambda: plots.comparison({"": numerical}),
        "figure10": lambda: plots.accuracy_over_noise(trials),
        "figure11": lambda: plots.record(rigs[1].rig),
        "figure12": lambda: plot_tree(rigs[1].equations, "v").figure,
        "figure13": lambda: plots.comparison({f"exp. {e}": one for e, one in rigs.items()}),
    }
    for name in wanted:
        with plots.style():
            yield plots.save(drawers[name](), folder / name)
