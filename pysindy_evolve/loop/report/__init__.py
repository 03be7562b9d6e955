"""The report of the loop: equations, errors before and after, evidence, pictures, experiments.

Begin with `report.py`: the methods of `LoopReport` lead to all other files. These take the outcome
that a report holds, see `facts/outcome.py`, and decide nothing but what is said.

==================  ===================================================================
contents
report              LoopReport: the outcome with all that prints, draws and simulates it
sindy               the equations as a fitted SINDy model
sentences
text                the printed report, and the same as Markdown
verdict             the verdict in a sentence
effect_text         the lines about one effect
printed_names       "quadratic drag" of a velocity is a "quadratic term" of a population
number_text         numbers with their intervals and units, percentages
remains             the best candidate that did not pass, and the cautions
limits of validity
cautions            all cautions of a report; most come from the files below and from facts
grown_errors        errors on held-out data that are larger with the effects
missed              the model misses the records by more than noise explains
unexplained         derivatives whose residual sensor noise does not explain
slow_states         a drift or the residual may be a state too slow for the loop to look for
extrapolation       held-out data is outside the range of the training data
fast_motion         an error of the free run that is faster than the low-pass
dilution            noise makes a parameter too small, as its terms hardly vary
exchangeable_poles  a lag and a first-order equation may have exchanged their poles
one_force           effects in several equations are the same force
experiments
experiment          the next measurement, chosen to tell similar effects apart
motions             imagined motions: the recorded one, larger, smaller, faster or slower
advice              experiments, and the plan of them in sentences
pictures and pages
plot                a page of panels of the residual, before and after the effects
panels              the panels: over time, frequency, one variable, two variables
html                the report as one HTML page
==================  ===================================================================
"""
