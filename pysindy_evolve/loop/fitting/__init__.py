"""Coefficients fitted to derivatives, trajectories and free runs.

`fit.py` is where to begin: it fits derivatives first, then simulations where these do better.

================  ==========================================================================
fits
fit               coefficients of a design, with their uncertainty
linear            least squares for columns of very different size
shooting          multiple shooting: coefficients adjusted until free runs meet the record
trial             multiple shooting of many models at once, with held-out errors
trajectory        fits to integrated equations, for records with few independent numbers
bootstrap         intervals of coefficients, from randomly weighted blocks of rows
errors
residual          what a model leaves unexplained, in the derivative and in the simulation
runs              free runs of a model over records, and their errors
disturbances
random_force      weights for trajectories with sensor noise and a random force
aliases           removes the error of sampled states where an input moves in steps
switches, memory
saltation         how a switch changes a small deviation of a run
past              initial hidden states, from the first rows of a record
unfolding         a term with memory as an additional state, so that runs can begin anywhere
================  ==========================================================================
"""
