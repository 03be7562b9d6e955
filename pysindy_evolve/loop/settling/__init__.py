"""The end of the loop: what was found is named, fitted for good, and withdrawn where it must be.

`settle.py` is where to begin.

================  ================================================================================
in order
settle            calls the files below; repeats until no effect is withdrawn
named rightly
contest           what could replace each effect, which of these is named, and which runs rule out
other_names       the names that are right beside all others, as of a friction beside an offset
fitted for good
judge             fits a model, and takes its errors on held-out records
stages            the declared model, and the model after each step, fitted and judged
bias              removes from coefficients what sensor noise adds to them
quantities        delays, time constants and limits, with their intervals
shape_intervals   intervals of the numbers inside effects
descriptions      effects in words, with the share of the error that each explains
assembly          the outcome, made from all stages together
withdrawn
zero_in_interval  an effect whose interval contains zero
transfer          an effect that differs from record to record
random_walks      an effect of the time that a random walk shows as well
worse_runs        an effect that makes free runs diverge, or with which nothing is closer
================  ================================================================================
"""
