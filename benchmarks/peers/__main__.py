"""Table 5 of the paper with the methods of today: each on the same rows, on one thread.

    OMP_NUM_THREADS=1 python benchmarks/peers [--seeds 3] [--only pysindy] [--results DIR]

Each method is a function in a file ``peer_*.py`` that holds what a user would write, with its
settings as docstring. It runs in a process of its own. A row that is finished is kept in
``rows.jsonl`` of the results folder and not run again; a method that fails, or is not installed,
is a row with its error. ``pip install "pysindy-evolve[peers]"`` brings the peers.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from table import as_markdown

HERE = Path(__file__).parent
PROBLEMS = ("frictionless", "friction")
PEERS = (
    "peer_evolve", "peer_pysindy", "peer_sysidentpy", "peer_pyoperon", "peer_gplearn", "peer_deap",
)  # fmt: skip
SLOWEST = 3600  # s that a method may take

Row = dict[str, object]


def child(*arguments: object, timeout: float = SLOWEST) -> str:
    """Run this benchmark's `run.py` in a lean process and return what it prints."""
    threads = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMEXPR")}
    done = subprocess.run(
        [sys.executable, HERE / "run.py", *map(str, arguments)],
        env=os.environ | threads,
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )
    if done.returncode:
        last = (done.stderr.strip() or f"exit code {done.returncode}").splitlines()[-1]
        raise RuntimeError(last)
    return done.stdout


def methods(only: str) -> Iterator[tuple[str, str]]:
    """Yield file and label of each method whose file or label holds `only`."""
    for peer in PEERS:
        try:
            labels = child("list", peer).splitlines()
        except RuntimeError:
            labels = [peer]  # it is not installed, which its row will say
        yield from ((peer, label) for label in labels if only in peer or only in label)


def measure(peer: str, label: str, data: Path, seed: int) -> Row:
    """Run one method on one problem; its failure is a result."""
    try:
        return json.loads(child("run", peer, label, data, seed).splitlines()[-1])
    except (RuntimeError, subprocess.TimeoutExpired, json.JSONDecodeError, IndexError) as error:
        return {"error": str(error)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="runs of each method")
    parser.add_argument("--only", default="", help="run methods whose label or file holds this")
    parser.add_argument("--problems", nargs="*", default=PROBLEMS, choices=PROBLEMS)
    parser.add_argument("--results", type=Path, default=Path("results/peers"))
    parser.add_argument("--print", action="store_true", help="print what there is, run nothing")
    options = parser.parse_args()

    options.results.mkdir(parents=True, exist_ok=True)
    path = options.results / "rows.jsonl"
    rows = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    finished = {(row["method"], row["problem"], row["seed"]) for row in rows}
    for seed in range(0 if options.print else options.seeds):
        for problem in options.problems:
            data = options.results / f"{problem}-{seed}.npz"
            if not data.exists():
                child("data", problem, seed, data)
            for peer, label in methods(options.only):
                if (label, problem, seed) in finished:
                    continue
                row = {"method": label, "problem": problem, "seed": seed}
                row |= measure(peer, label, data, seed)
                rows.append(row)
                with path.open("a") as file:
                    file.write(json.dumps(row) + "\n")
                print(f"{problem}, seed {seed}: {label}: {_short(row)}", file=sys.stderr)
    print(as_markdown(rows, PROBLEMS))


def _short(row: Row) -> str:
    if "error" in row:
        return str(row["error"])
    return f"exact {row['exact']}, {row['validation_error']:.3g} %, {row['cpu']:.2f} s"


if __name__ == "__main__":
    main()
