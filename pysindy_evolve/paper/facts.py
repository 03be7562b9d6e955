"""Numbers from the paper: settings, identified equations, errors and times. Nothing is computed.

Tables 1 and 3 are the settings; a row of table 2 or 4 has the coefficients as they are printed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

PARTS = (
    "table2", "figure10", "table4", "table5",
    "figure4", "figure5", "figure8", "figure9", "figure11", "figure12", "figure13",
)  # fmt: skip
CLEAN_DOWN_TO = 17.0  # dB: below it the paper finds extra terms, figure 10


@dataclass(frozen=True)
class Row:
    """An identified equation as the paper prints it, and its error on validation data in %."""

    equation: str
    error: float


@dataclass(frozen=True)
class Setting:
    """Parameters of the search, as `EvolvingLibrary` takes them."""

    table: str
    options: dict[str, Any] = field(hash=False)


NUMERICAL = Setting(
    "table 1",
    {
        "operators": ("add", "sub", "mul", "abs", "sgn"),
        "population_size": 80,
        "n_generations": 30,
        "crossover_rate": 0.9,
        "mutation_rate": 0.1,
    },
)
RIG = Setting(
    "table 3",
    {
        "operators": ("add", "sub", "div", "mul", "abs", "sgn"),
        "population_size": 150,
        "n_generations": 40,
        "crossover_rate": 0.8,
        "mutation_rate": 0.2,
    },
)

THEORY = "−3.67 v − 993.88 q − 2.18e6 q^3 − zdd"
TABLE_2 = {
    20.0: Row("−3.67 v − 994.19 q − 2.18e6 q^3 − zdd", 0.7),
    19.5: Row("−3.67 v − 994.81 q − 2.19e6 q^3 − 0.99 zdd", 1.9),
    19.0: Row("−3.67 v − 984.64 q − 2.15e6 q^3 − zdd", 3.7),
    18.5: Row("−3.73 v − 867.83 q − 1.72e6 q^3 − 1.02 zdd", 11.2),
}
TABLE_4 = {
    1: Row(
        "−1.10 v − 691.92 q − 2.37e6 q^3 − 2.93 sgn(v) − 7.63e3 q^2 sgn(v) − 1.02 zdd", 3.9
    ),
    2: Row(
        "−1.23 v − 714.60 q − 2.24e6 q^3 − 4.11 sgn(v) − 8.23e3 q^2 sgn(v) − 1.04 zdd", 5.6
    ),
    3: Row(
        "−1.22 v − 716.11 q − 2.35e6 q^3 − 3.81 sgn(v) − 8.26e3 q^2 sgn(v) − 1.04 zdd", 4.7
    ),
}  # fmt: skip
# Seconds on the authors' machine and error in %, for experiments 1, 2 and 3.
TABLE_5 = {
    "genetic programming (population 250, 80 generations)": ((449, 426, 539), (5.7, 5.3, 4.1)),
    "sparse regression, sgn put in by hand": ((2.1, 2.6, 2.7), (3.9, 4.6, 5.2)),
    "ESparse": ((12.6, 12.2, 12.1), (3.9, 5.6, 4.7)),
}
