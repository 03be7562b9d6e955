"""What `__main__` does in processes of their own: make the data, list methods, run one.

The parent stays small, because a child's peak memory never falls below that of its parent.
"""

from __future__ import annotations

import importlib
import inspect
import json
import os
import resource
import sys
import time
import warnings
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

GIVEN = ("__future__", "typing", "from run", "numpy")  # imports that are no peer's
SAME = 1e-6  # share of the acceleration up to which a prediction is made of the true terms


class Data(NamedTuple):
    """What a method gets: x is q and v, u is zdd, x_dot is v and the noisy acceleration."""

    t: np.ndarray
    x: np.ndarray
    u: np.ndarray
    x_dot: np.ndarray
    names: tuple[str, ...] = ("q", "v", "zdd")

    @property
    def columns(self) -> np.ndarray:
        """q, v and zdd, as plain regressors take them: (n_samples, 3)."""
        return np.column_stack([self.x, self.u])

    @property
    def a(self) -> np.ndarray:
        """The noisy acceleration: (n_samples,)."""
        return self.x_dot[:, 1]


class Found(NamedTuple):
    """What a method returns: its equation as text, and its prediction from q, v and zdd."""

    equation: str
    predict: Callable[[np.ndarray], np.ndarray]


def write_data(problem: str, seed: int, path: str) -> None:
    """Simulate a rig of the paper: 20 dB without friction, 30 dB with, noise on the target."""
    from pysindy_evolve.datasets import duffing

    friction = problem == "friction"
    rig = duffing(
        friction=friction, experiment=1, snr_db=30.0 if friction else 20.0, random_state=seed
    )
    train = {name: getattr(rig, name)[rig.train] for name in ("t", "x", "u", "x_dot")}
    # Where the mass sticks, its acceleration is no function of the state, and is left out.
    moves = np.arange(len(rig.t))[rig.validation]
    moves = moves[rig.v[moves] != 0.0]
    terms = [rig.v, rig.q, rig.q**3, rig.zdd]
    if friction:
        terms += [np.sign(rig.v), rig.q**2 * np.sign(rig.v)]
    theta = np.column_stack(terms)[moves]
    coef = np.linalg.lstsq(theta, rig.a[moves], rcond=None)[0]
    columns = np.column_stack([rig.x, rig.u])[moves]
    np.savez(path, theta=theta, coef=coef, a=rig.a[moves], columns=columns, **train)


def run(peer: str, label: str, path: str, seed: int) -> dict[str, object]:
    """Fit one method to the training rows and judge it on the validation rows."""
    method = _method(peer, label)
    with np.load(path) as file:
        data = Data(*(file[name] for name in Data._fields[:4]))
    before, start = _peak(), time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a table of figures has no place for them
        found = method(data, seed)
    cpu, peak = time.process_time() - start, _peak()
    with np.load(path) as file:
        theta, coef, a, columns = (file[name] for name in ("theta", "coef", "a", "columns"))
    predicted = np.asarray(found.predict(columns), dtype=float).reshape(len(a))
    exact, coefficient_error = _structure(theta, coef, predicted)
    return {
        "exact": exact,
        "coefficient_error": coefficient_error,
        "validation_error": 100.0 * float(np.std(predicted - a) / np.std(a)),
        "cpu": cpu,
        "memory": (peak - before) / 1024.0,
        "data": sum(part.nbytes for part in data[:4]) / 2**20,
        "rows": len(data.t),
        "lines": _lines(method),
        "load": os.getloadavg()[0],
        "note": " ".join((method.__doc__ or "").split()),
        "equation": found.equation[:2000],
    }


def _structure(
    theta: np.ndarray, coef: np.ndarray, predicted: np.ndarray
) -> tuple[str, float | None]:
    """Tell whether a prediction is a sum of the true terms, and how far its coefficients are off.

    Whatever a method's equation looks like, it is exact if its prediction lies in the span of the
    true terms, with none of them missing. An intercept beside them is said apart.
    """
    if not np.isfinite(predicted).all():
        return "invalid", None
    columns = np.column_stack([theta, np.ones(len(theta))])
    scale = np.sqrt(np.mean(columns**2, axis=0))
    fitted = np.linalg.lstsq(columns / scale, predicted, rcond=None)[0]
    size = np.std(theta @ coef)
    left = np.std(predicted - columns / scale @ fitted)
    if left > SAME * size or np.any(np.abs(fitted[:-1]) < SAME * size):
        return "no", None
    error = 100.0 * float(np.max(np.abs(fitted[:-1] / scale[:-1] / coef - 1.0)))
    return ("yes" if abs(fitted[-1]) <= SAME * size else "with offset"), error


def _peak() -> int:
    """Return the most memory that this process held, in KiB (Linux)."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _method(peer: str, label: str) -> Callable[[Data, int], Found]:
    return importlib.import_module(peer).METHODS[label]


def _lines(method: Callable[[Data, int], Found]) -> int:
    """Count the lines of code of a method, of what it calls in its own file, and of imports."""
    module = inspect.getmodule(method)
    imports = [line for line in inspect.getsource(module).splitlines() if "import " in line[:40]]
    imports = [line for line in imports if not any(name in line for name in GIVEN)]
    functions = [method]
    for function in functions:  # which grows as it is walked
        called = (module.__dict__.get(name) for name in function.__code__.co_names)
        functions += [f for f in called if inspect.isfunction(f) and f not in functions]
    functions = [f for f in functions if inspect.getmodule(f) is module and f.__name__ != "load"]
    return len(imports) + sum(len(_code(function)) for function in functions)


def _code(function: Callable) -> list[str]:
    source = inspect.getsource(function).replace(function.__doc__ or "", "")
    lines = [line.strip() for line in source.splitlines()]
    return [line for line in lines if line and not line.startswith(("#", '"""', "def "))]


def main(task: str, *arguments: str) -> None:
    if task == "data":
        write_data(arguments[0], int(arguments[1]), arguments[2])
    elif task == "list":
        print(*importlib.import_module(arguments[0]).METHODS, sep="\n")
    else:
        peer, label, path, seed = arguments
        print(json.dumps(run(peer, label, path, int(seed))))


if __name__ == "__main__":
    main(*sys.argv[1:])
