"""What the loop says: equations, errors before and after, evidence, pictures, experiments.

`report.py` is where to begin: the methods of `LoopReport` lead to all other files.

==================  ===================================================================
contents
report              LoopReport: equations and errors before and after, and the effects
effect              one effect with its evidence; the errors of one model
sindy               the equations as a fitted SINDy model
numbers
residuals           the part of a measured derivative that a model leaves
unexplained         the part of this residual that sensor noise does not explain
start_noise         how far noise in the first state moves a free run
readings            a run as clipping sensors would show it
sentences
text                the printed report, and the same as Markdown
effect_text         the lines about one effect
interval_text       numbers with their intervals, with as many digits as these justify
units               labels with units, percentages
remains             what is left at the end of the search, and what that means
limits of validity
cautions            all cautions of a report; most come from the files below
missed              the model misses the records by more than noise
slow_states         a drift, or what is left, may be a state too slow to be looked for
extrapolation       held-out data is outside the range of the training data
unidentified        the records do not determine a declared parameter
dilution            noise makes a parameter too small, as too little moved
exchangeable_poles  a lag and a first-order equation may have exchanged their poles
held_delays         a delay of less than a sampling time may be a held input
one_force           effects in several equations may be one and the same force
between records
record_numbers      a declared number differs from record to record
record_offsets      an offset differs from record to record
shared_lines        the residuals of all records share a frequency that no input has
experiments
experiment          the next measurement, chosen to tell similar effects apart
motions             motions to try: the recorded one, larger, smaller, faster or slower
advice              the plan of experiments in sentences
pictures and pages
plot                a page of panels of the residual, before and after
panels              the panels: over time, frequency, one variable, two variables
html                the report as one HTML page
==================  ===================================================================
"""
