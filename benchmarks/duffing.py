"""Run the simulated Duffing rigs of the paper: exact structure, error and time.

    OMP_NUM_THREADS=1 python benchmarks/duffing.py [--seeds 20]

The frictionless rig (equation 3) has 107 000 rows for identification and 20 dB of white noise on
the acceleration; the rig with friction (equation 7, table 4, experiment 1) has 279 000 rows and 20
or 30 dB. `exact` counts the runs whose every equation has the true terms and no other. The rival
is PySINDy's own fit with the sgn terms put in by hand, which somebody had to know, STLSQ with its
defaults and nothing swept. Times are processor seconds of ``fit``, one thread.
"""

from __future__ import annotations

import argparse
import time
import warnings

import numpy as np
import pysindy as ps

import pysindy_evolve as pse
from pysindy_evolve.datasets import duffing

# Table 1 of the paper; population 80, crossover 0.9, mutation 0.1, 30 generations are defaults.
OPERATORS = ("add", "sub", "mul", "abs", "sgn")
TRUE = {"v", "q", "q^3", "zdd"}
TRUE_WITH_FRICTION = TRUE | {"sgn(v)", "q^2 sgn(v)"}
ROWS = ((False, 20.0), (True, 20.0), (True, 30.0))


def evolved(seed: int) -> ps.SINDy:
    library = pse.EvolvingLibrary(operators=OPERATORS, random_state=seed)
    return ps.SINDy(feature_library=library, optimizer=pse.ElasticNet())


def by_hand() -> ps.SINDy:
    signs = ps.CustomLibrary(
        [lambda a: np.sign(a), lambda a, b: a * a * np.sign(b)],
        [lambda a: f"sgn({a})", lambda a, b: f"{a}^2 sgn({b})"],
    )
    library = ps.PolynomialLibrary(degree=3) + signs
    return ps.SINDy(feature_library=library, optimizer=ps.STLSQ())


def timed_fit(model: ps.SINDy, rig, part: slice) -> float:
    start = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # STLSQ says that it eliminated everything
        model.fit(
            rig.x[part], rig.t[part], x_dot=rig.x_dot[part], u=rig.u[part],
            feature_names=list(rig.names),
        )  # fmt: skip
    return time.process_time() - start


def error(model: ps.SINDy, rig, truth: np.ndarray) -> float:
    """Error of the acceleration on the validation part against the clean one, percent.

    Where the mass sticks, its acceleration is no function of the state, and is left out.
    """
    part = rig.validation
    moves = rig.v[part] != 0.0
    predicted = np.asarray(model.predict(rig.x[part], u=rig.u[part]))[moves, 1]
    return 100.0 * float(np.std(predicted - truth[part][moves]) / np.std(truth[part][moves]))


def is_exact(model: ps.SINDy, friction: bool) -> bool:
    names = model.get_feature_names()
    rows = model.coefficients() != 0.0
    found = [{n for n, used in zip(names, row, strict=True) if used} for row in rows]
    return found == [{"v"}, TRUE_WITH_FRICTION if friction else TRUE]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20)
    seeds = range(parser.parse_args().seeds)
    print("rig            SNR    rows  exact  error %          fit s   by hand s  ratio  error %")
    for friction, snr in ROWS:
        exact, errors, times, rival_times, rival_errors = 0, [], [], [], []
        for seed in seeds:
            rig = duffing(friction=friction, experiment=1, snr_db=snr, random_state=seed)
            model = evolved(seed)
            times.append(timed_fit(model, rig, rig.train))
            errors.append(error(model, rig, rig.a))
            right = is_exact(model, friction)
            exact += right
            if not right:
                print(f"  seed {seed}: {model.equations(precision=6)[1]}")
            if seed < 3:
                rival = by_hand()
                rival_times.append(timed_fit(rival, rig, rig.train))
                rival_errors.append(error(rival, rig, rig.a))
        n_rows = rig.train.stop - rig.train.start
        print(
            f"{'friction' if friction else 'frictionless':13}{snr:4.0f} dB{n_rows:8}"
            f"{exact:4}/{len(seeds)}  {np.mean(errors):.3f} +- {np.std(errors):.3f}"
            f"{np.median(times):9.2f}{np.median(rival_times):11.2f}"
            f"{np.median(times) / np.median(rival_times):8.1f}{np.mean(rival_errors):9.1f}"
        )


if __name__ == "__main__":
    main()
