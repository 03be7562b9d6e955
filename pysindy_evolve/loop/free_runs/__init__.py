"""What only free runs of a model show: slow memories, limits, effects to exchange.

`named_effects.py` is where to begin; `drift.py` holds the measure that most other files use.

====================  =======================================================================
searches
named_effects         memories, limits and named effects that only free runs show
unnamed_terms         small terms without a name that only free runs show
sensor_limits         sensors that clip
state_limits          states that stop at a limit
exchanges
one_for_one           replaces an effect by a similar one whose runs are closer to the record
one_for_several       replaces several effects by one
two_for_one           replaces one effect by two
one_in_two_equations  replaces two effects by one that stands in both equations
contenders            which effects and terms may replace an effect
leading_terms         terms that bring runs closest to the record, to first order
other_forms           simpler forms of a grown term
quotients             quotients and powers that a grown exponential or tanh may stand for
tuning
memory_tuning         numbers inside memories, such as a time constant
shape_tuning          numbers inside an effect, such as the width of a dead zone
shared_tuning         numbers that effects of several equations share
measures
variants              a model for free runs, and its variants with one more memory or term
judging               whether the gain of a variant is more than chance
drift                 how far runs drift from the record, and how far by chance
heldout               errors on stretches that a model was not fitted to
whitening             removes from each error what earlier errors predict
plateaus              how long a reading stays at its extreme, in records and in twins
====================  =======================================================================
"""
