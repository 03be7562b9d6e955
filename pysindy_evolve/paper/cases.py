"""Which simulated records each table needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from ..datasets import DuffingRig, duffing
from .facts import NUMERICAL, RIG, TABLE_2, TABLE_4, Setting

System = Literal["numerical", "friction", "rig"]

SNR_RIG = 30.0  # dB on each accelerometer in table 4
SEEDS = 20


@dataclass(frozen=True)
class Case:
    """One simulated record and the search on it.

    Parameters
    ----------
    system : {"numerical", "friction", "rig"}
        The Duffing oscillator of equation (3), or that of equation (7) with friction, each with
        noise on its acceleration; or the latter, measured only by two noisy accelerometers.
    snr_db : float
        Power of the signal over that of the noise, dB.
    seed : int
        Seed of the noise and of the search.
    experiment : {0, 1, 2, 3}
        Row of table 4; 0 for the numerical oscillator.
    fused : bool
        Whether the measured acceleration is first joined with the slope of the measured velocity,
        see `signals.fuse`.
    """

    system: System
    snr_db: float
    seed: int
    experiment: int = 0
    fused: bool = False

    @property
    def setting(self) -> Setting:
        """Parameters of the search that the paper used."""
        return NUMERICAL if self.system == "numerical" else RIG

    def simulate(self) -> DuffingRig:
        """Return the record; the motion is simulated once, the noise each time."""
        if self.system == "numerical":
            return duffing(snr_db=self.snr_db, random_state=self.seed)
        return duffing(
            friction=True,
            experiment=self.experiment,
            snr_db=self.snr_db,
            accelerometers=self.system == "rig",
            random_state=self.seed,
        )


@dataclass(frozen=True)
class Plan:
    """Seeds and signal-to-noise ratios of the runs.

    Parameters
    ----------
    seeds : tuple of int
        One run of each case for each seed.
    table2, figure10, table4, friction : tuple of float
        Signal-to-noise ratios, dB; with `friction`, noise is on the acceleration only.
    """

    seeds: tuple[int, ...]
    table2: tuple[float, ...] = tuple(TABLE_2)
    figure10: tuple[float, ...] = tuple(float(snr) for snr in range(20, 4, -1))
    table4: tuple[float, ...] = (SNR_RIG, 25.0, 20.0, 15.0)
    friction: tuple[float, ...] = (SNR_RIG, 20.0)

    def cases(self, parts: Sequence[str]) -> list[Case]:
        """Return the cases that the parts need, without duplicates, those of a table together."""
        makers = {
            "table2": self.for_table2,
            "figure10": self.for_figure10,
            "table4": self.for_table4,
            "table5": self.for_table5,
        }
        wanted = (make() for part, make in makers.items() if part in parts)
        return list(dict.fromkeys(case for cases in wanted for case in cases))

    def for_table2(self) -> list[Case]:
        """Return the records of table 2, each with and without fusion."""
        return [
            Case("numerical", snr, seed, fused=fused)
            for fused in (True, False)
            for snr in self.table2
            for seed in self.seeds
        ]

    def for_figure10(self) -> list[Case]:
        """Return the records of figure 10."""
        return [Case("numerical", snr, seed) for snr in self.figure10 for seed in self.seeds]

    def for_table4(self) -> list[Case]:
        """Return the records of table 4: those at 30 dB, and those with more noise."""
        return [*self.for_table5(), *self.by_noise()]

    def for_table5(self) -> list[Case]:
        """Return the records of table 5: each experiment at 30 dB."""
        return [Case("rig", SNR_RIG, seed, e) for e in TABLE_4 for seed in self.seeds]

    def by_noise(self) -> list[Case]:
        """Return one record for each noise and seed, of the experiments in turn."""
        noises: list[tuple[System, float]] = [("rig", snr) for snr in self.table4]
        noises += [("friction", snr) for snr in self.friction]
        return [
            Case(system, snr, seed, 1 + seed % len(TABLE_4))
            for system, snr in noises
            for seed in self.seeds
        ]


def plan(n_runs: int = SEEDS, *, first_seed: int = 0, quick: bool = False) -> Plan:
    """Return a plan: the paper's 20 runs of each case, or a few for a quick look.

    Parameters
    ----------
    n_runs : int
        Runs of each case.
    first_seed : int
        Seed of the first run; the others follow.
    quick : bool
        At most two runs, and fewer signal-to-noise ratios.

    Returns
    -------
    Plan
    """
    seeds = tuple(range(first_seed, first_seed + n_runs))
    if quick:
        return Plan(
            seeds[:2],
            table2=(20.0, 18.5),
            figure10=(20.0, 12.0, 5.0),
            table4=(SNR_RIG,),
            friction=(),
        )
    return Plan(seeds)
