"""The loop: declared model and measurement in, corrected equation and its evidence out.

`close.py` is what a user calls, `search.py` the order of the looks. Each folder may use those above
it in this table:

=============  ====================================================================
given          the declared model, the records, pieces of them, the rules
effects        the vocabulary, as columns that an equation may lack
fitting        coefficients, from derivatives, trajectories and free runs
twins          machines in which nothing is missing
evidence       one step: effects scored, tested on twins, held against rivals
memories       what an input goes through before it acts
free_runs      what only free runs show: slow memories, limits, effects held against each other
growth         terms that no name fits, by genetic programming
revision       what was found, exchanged, tuned again or dropped
report         equations, errors, evidence, pictures, experiments
=============  ====================================================================
"""

from .close import close_loop
from .given.declared import DeclaredModel
from .report.report import Effect, LoopReport

__all__ = ["DeclaredModel", "Effect", "LoopReport", "close_loop"]
