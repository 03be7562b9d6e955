"""What a loop costs: `python benchmarks/loop_time.py`.

Each machine lacks one effect of 5 % of the force; its position has 0.5 % of noise. The time is that
of `close_loop` alone, from the prepared record to the report. Each figure comes from a process of
its own, whose peak memory is given beside it, without that of the processes that work on twins.
The figures of a row are to be compared with each other, as the speed of a machine varies.
"""

import argparse
import json
import resource
import subprocess
import sys
import time

from machines.records import generator, measure
from machines.simulation import scaled_effect
from undeclared import declare

import pysindy_evolve as pse

CASES = (("oscillator", "Coulomb"), ("two masses", "Coulomb"), ("circuit", "square"))


def loop(name, effect, n, n_twins, n_jobs):
    text, _ = scaled_effect(name, effect, 0.05, n)
    record = measure(name, n, "white", generator(0, name, effect), text)
    begin = time.perf_counter()
    report = pse.close_loop(declare(name), record, n_twins=n_twins, n_jobs=n_jobs, random_state=0)
    seconds = time.perf_counter() - begin
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    return seconds, megabytes, ", ".join(e.name for e in report.effects) or report.verdict


def measured(*case):
    """Run a loop in a process that ends with it, and with it the processes that work on twins."""
    given = json.dumps(case)
    found = subprocess.run([sys.executable, __file__, "--case", given], capture_output=True)
    return json.loads(found.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--n", type=int, nargs="+", default=[10_000], help="raw samples")
    parser.add_argument("--n-twins", type=int, default=100)
    parser.add_argument("--n-jobs", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--case", help="one figure, as JSON: machine, effect, n, twins, processes")
    given = parser.parse_args()
    if given.case:
        print(json.dumps(loop(*json.loads(given.case))))
        return
    jobs = "".join(f"{f'{n} process' + 'es' * (n > 1):>14}" for n in given.n_jobs)
    print(f"{'machine':<12}{'samples':>9}{jobs}{'ratio':>8}{'peak':>9}  named")
    for case in CASES:
        for n in given.n:
            runs = [measured(*case, n, given.n_twins, n_jobs) for n_jobs in given.n_jobs]
            seconds = [run[0] for run in runs]
            times = "".join(f"{s:>12.1f} s" for s in seconds)
            peak = max(run[1] for run in runs)
            print(
                f"{case[0]:<12}{n:>9}{times}{seconds[-1] / seconds[0]:>8.2f}{peak:>6.0f} MB", end=""
            )
            print(f"  {runs[0][2]}", flush=True)


if __name__ == "__main__":
    main()
