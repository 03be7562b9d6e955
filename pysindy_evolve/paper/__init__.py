"""The tables and figures of the paper, made again: what the command `paper` runs.

The paper is Goharoodi, Dekemele, Loccufier, Dupre, Crevecoeur, Mathematical Problems in Engineering
2020, 7286575, doi:10.1155/2020/7286575. Its laboratory record is not public; a rig simulated from
its equation (7) and the coefficients of its table 4 takes its place.
"""

from .cases import Plan, plan
from .facts import PARTS
from .results import Results, forget, reproduce

__all__ = ["PARTS", "Plan", "Results", "forget", "plan", "reproduce"]
