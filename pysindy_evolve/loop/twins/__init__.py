"""Twins: machines in which nothing is missing, and what a statistic is worth among them.

`twins.py` is where to begin.

=============  ===================================================================
twins          twins of records: the model, sensor noise, and a residual of chance
paths          a path without noise close to a record, which twins follow
signs          residuals times slow random signals: functions of nothing
colored        twins whose sensors have all the noise, which may be colored
drifting       twins of trajectories, pushed by a random force
what they say
values         values of a statistic on twins, by several processes
chance         the p-value that follows from these values
=============  ===================================================================
"""
