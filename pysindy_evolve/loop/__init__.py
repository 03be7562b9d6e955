"""The loop: declared model and measurement in, corrected equation and its evidence out.

`close.py` is what a user calls. It gives the records to `search/look_for_effects.py`, where the
looks stand in their order, and what these `Found` to `settling/settle.py`, where it is fitted for
good and what does not hold is withdrawn. The `Outcome` becomes a `LoopReport`. Each folder may use
those above it in this table:

=============  ====================================================================
given          the declared model, the records, pieces of them, the rules
effects        the vocabulary, as columns that an equation may lack
fitting        coefficients, from derivatives, trajectories and free runs
twins          machines in which nothing is missing
evidence       one step: effects scored, tested on twins, held against rivals
memories       what an input goes through before it acts
free_runs      what only free runs show: slow memories, limits, effects held against each other
growth         terms that no name fits, by genetic programming
revision       what was found, exchanged, tuned again or dropped while the search goes on
search         the looks in their order, and what they have found so far
facts          the outcome as data, and what it says of the records in numbers
settling       what was found under its right name, fitted for good, or withdrawn
report         equations, errors, evidence, pictures, experiments: what people read
=============  ====================================================================
"""

from .close import close_loop
from .facts.effect import Effect
from .given.declared import DeclaredModel
from .report.report import LoopReport

__all__ = ["DeclaredModel", "Effect", "LoopReport", "close_loop"]
