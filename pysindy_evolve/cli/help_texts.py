"""The text that --help prints for each command, with examples to copy."""

from __future__ import annotations

ABOUT = """\
Give it your model and your measurements; it grows the PySINDy terms your model is missing,
proves them on data it has not seen, and hands back the corrected equation."""

EXAMPLES = """\
examples:
  pysindy-evolve demo
  pysindy-evolve fit rig.csv --position q --inputs F
  pysindy-evolve loop rig.csv --position q --inputs F \\
      --equation "q = v" --equation "v = -k*q - c*v + b*F"
  pysindy-evolve paper --quick

Each command has a --help of its own."""

FIT = """\
Evolve equations from named columns of CSV files. The last 30 % of a file, or the last of
several files, judge the result; --test names others."""

FIT_EXAMPLES = """\
examples:
  Position q and force F were measured; velocity and acceleration are derived from q:
    pysindy-evolve fit rig.csv --position q --inputs F
  Both states were measured, and the acceleration in a column named acc:
    pysindy-evolve fit rig.csv --states q,v --inputs F --target v=acc
  Two records to fit on, one to judge on, and C code of the result:
    pysindy-evolve fit a.csv b.csv --test c.csv --states T1,T2 --inputs Q --code c"""

LOOP = """\
Find what a declared model lacks, add it, and report the errors before and after. The last
30 % of a file, or the last of several files, judge the result; --test names others."""

LOOP_EXAMPLES = """\
examples:
  Position q and force F were measured; k, c and b are fitted, and what is missing is found:
    pysindy-evolve loop rig.csv --position q --inputs F \\
        --equation "q = v" --equation "v = -k*q - c*v + b*F"
  The mass is known, another record judges, report and picture are saved in a folder:
    pysindy-evolve loop rig.csv --test other.csv --position q --inputs F --known m=95.1 \\
        --equation "q = v" --equation "v = F/m - c*v" --report results
  All states were measured, so there is no --position:
    pysindy-evolve loop tanks.csv --inputs u \\
        --equation "h1 = a*u - b*sqrt(h1)" --equation "h2 = c*sqrt(h1) - d*sqrt(h2)"
  The columns have long names, and are called q and F in the equations:
    pysindy-evolve loop rig.csv --time "Time [s]" --position "q=Position [mm]" \\
        --inputs "F=Force (N)" --equation "q = v" --equation "v = -k*q - c*v + b*F"

In an equation, names that are neither a state, an input, t nor known are free parameters. They
are fitted and must enter linearly; they are listed before the search begins.

Expect 5 to 20 s for 10 000 samples of one position on one quiet core, a minute or more for two
joints or bodies, and more with each effect found; a bar on a terminal shows where the search is
(--quiet hides it), and Ctrl-C reports what was found."""
