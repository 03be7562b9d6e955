"""Twins: simulated records in which nothing is missing, and p-values from them.

`twins.py` is where to begin.

=============  ===================================================================
twins          twins of records: the model, sensor noise, a randomized residual
paths          a noise-free path close to a record, which twins follow
signs          residuals times slow random signals, so that they depend on nothing
colored        twins whose whole residual is sensor noise, which may be colored
drifting       twins of trajectories, pushed by a random force
p-values
chance         values of a statistic on twins, and the p-value that follows from them
=============  ===================================================================
"""
