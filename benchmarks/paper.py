"""Make the tables and figures of the paper again, as `pysindy-evolve paper` does.

OMP_NUM_THREADS=1 python benchmarks/paper.py [--quick] [--runs 20] [--only table2,figure10]
"""

from __future__ import annotations

import sys

from pysindy_evolve.cli import main

if __name__ == "__main__":
    sys.exit(main(["paper", *sys.argv[1:]]))
