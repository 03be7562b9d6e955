"""A second look at what was found: exchanged, tuned again, or dropped.

`revise.py` is where to begin.

================  =================================================================
exchanged
revise            exchanges, merges and drops effects
hyperbolas        hyperbolas in the place of coefficients that vary in proportion
tuned again
hidden_numbers    the numbers of a hysteresis or a relaxation
shared_numbers    one number where effects in two equations are the same expression
past_inputs       the inputs before a record began, for memories of inputs
dropped
marginality       effects that only had to precede another one, such as an offset
thinning          effects that a term replaces once its numbers are tuned
superseded        memories, and findings of free runs, that later effects explain
errors_in_inputs  effects that explain no more than errors of the inputs
noise_in_runs     effects that remove no more from free runs than input noise adds
================  =================================================================
"""
