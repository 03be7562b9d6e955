"""Reproduces the tables and figures of the paper, for the command `paper`.

The paper is Goharoodi, Dekemele, Loccufier, Dupre, Crevecoeur, Mathematical Problems in Engineering
2020, 7286575, doi:10.1155/2020/7286575. Its laboratory record is not public. It is replaced by a
rig that is simulated from equation (7) and the coefficients of table 4.

`results.py` is where to begin.

==========  ====================================================================
runs
results     runs the trials that are not finished, then writes tables and figures
cases       which simulated records each table needs
trials      one trial: a simulated record, a fit, the error of the equation
store       the file of finished trials, so that an interrupted run can continue
numbers
facts       the numbers that the paper states
tables      tables of the paper beside our results, as Markdown and CSV
peers       results of other packages on the same data
pictures
figures     the content of each figure
plots       draws the figures; the only file that imports matplotlib
==========  ====================================================================
"""

from .cases import Plan, plan
from .facts import PARTS
from .results import Results, forget, reproduce

__all__ = ["PARTS", "Plan", "Results", "forget", "plan", "reproduce"]
