"""The end of the loop: what was found is named, fitted for good, and withdrawn where it must be.

`order.py` is where to begin.

===============  ===================================================================
named rightly
contest          what could stand in the place of each effect, and which of these is named
refuted          which of these free runs refute
asymmetry        friction that differs with the direction: one force in two names
dead_zones       a dead zone of an input, or its saturation
end_stops        on which side of it a stop stands
products         couplings, where grown terms are products of states
fitted for good
judge            a design, fitted and judged on held-out records
bias             what noise shifts in coefficients
quantities       delays, time constants and limits, with their intervals
shape_intervals  intervals of the numbers inside effects
assembly         all stages together in a report
withdrawn
doubtful         an effect whose sign is not known
transfer         one that differs from record to record
runaway          one with which the model leaves a record that it followed
worsened         one with which free runs miss more
===============  ===================================================================
"""
