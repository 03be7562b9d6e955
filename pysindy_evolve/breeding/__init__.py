"""What each generation of a search does: terms bred, evaluated, tuned and refitted.

`evolution.py`, one folder up, calls these steps in their order.

===============  =================================================================================
data
generation       settings of a search, the record of one generation, the result
denoise          rows to grow terms on: states are denoised, doubtful rows left out
new terms
genetics         random terms, crossover and mutation; the only file that imports DEAP
prefix           terms as prefix trees, which crossover and mutation cut and join, and back
plain            simple terms with an inner constant, such as sin(w x) y, for the first generation
relatives        simple products that may replace a term with a sum inside
evaluation
dictionary       terms evaluated on a sample of rows, and the cost of each term
poles            recognizes terms that become infinite between two samples
elastic_net      proposes which terms of a dictionary belong together
fitness          fitness of each term of a generation; lower is better
least_power      least sum of squares that a term must explain, given the noise in the variables
constants        tunes inner constants, such as w in sin(w x), by variable projection
end of a search
watch            progress bar, early end and interruption
plateau          whether the search has stagnated, or the residual is only noise
refit            the last step: the best terms weighed against each other on all rows
===============  =================================================================================
"""
