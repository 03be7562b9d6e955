"""Values of a statistic on twins, in which nothing is missing, and the p-value from them.

References
----------
Phipson and Smyth, Stat. Appl. Genet. Mol. Biol. 9 (2010), DOI 10.2202/1544-6115.1585: p-values are
never zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from joblib import Parallel, delayed
from tqdm.auto import tqdm

from ...threads import one_thread
from ..given.rules import Rules
from ..given.segments import Segments
from .colored import ColoredTwins
from .drifting import DriftingTwins
from .twins import TwinMaker

BATCH = 4  # twins, after which it is decided whether more are needed
# A statistic so many times the best of all twins passes without more of them.
MIN_RATIO_TO_TWINS = 2.0

Maker = TwinMaker | DriftingTwins | ColoredTwins
Statistic = Callable[[Segments], float]


def p_value_of(observed: float, values: np.ndarray | Sequence[float]) -> float:
    """Return (1 + number of values at least as large) / (1 + number of values)."""
    return float((1 + np.sum(np.asarray(values) >= observed)) / (1 + len(values)))


def draws_for(level: float, usual: int) -> int:
    """Return how many values a p-value as small as a level takes: the usual number, or more.

    The smallest p-value of n values is 1 / (n + 1).
    """
    return max(usual, int(np.ceil(1.0 / level - 1e-9)) - 1)


def chance_on_twins(
    maker: Maker,
    part: Segments,
    statistic: Statistic,
    observed: float,
    rules: Rules,
    rng: np.random.Generator,
) -> tuple[float, np.ndarray]:
    """Return the p-value of a statistic, and its value on each twin.

    The values are what the same search finds where nothing is missing. Twins come in batches. No
    more are made once so many of them reach the observed value that it fails (Besag and Clifford
    1991, DOI 10.1093/biomet/78.2.301), or once there are enough for it to pass and none comes near
    it.
    """
    children = rng.spawn(rules.n_twins)
    allowed = rules.level * (rules.n_twins + 1) - 1.0
    enough = 1.0 / rules.level - 1.0
    found: list[float] = []
    bar = tqdm(total=rules.n_twins, desc="twins", disable=not rules.progress, leave=False)
    with Parallel(n_jobs=rules.n_jobs) as parallel, bar:
        for start in range(0, rules.n_twins, BATCH):
            batch = children[start : start + BATCH]
            found += parallel(delayed(_in_twin)(maker, part, statistic, c) for c in batch)
            bar.update(len(batch))
            fails = np.sum(np.array(found) >= observed) > allowed
            passes = len(found) >= enough and observed > MIN_RATIO_TO_TWINS * max(found)
            if fails or passes:
                break
    return p_value_of(observed, found), np.array(found)


@one_thread()
def _in_twin(maker: Maker, part: Segments, statistic: Statistic, rng: np.random.Generator) -> float:
    return statistic(part.of(maker.make(rng)))
