"""One step of the loop: score effects on held-out pieces, test them on twins, compare rivals.

A twin is a simulated record in which nothing is missing. `step.py` is where to begin.

======================  ===================================================================
one step
step                    finds the best effect that a model lacks, and tests it on twins
offers                  which effects are candidates in this step
scoring                 fits candidates beside the columns of a design, and scores them
held_out_scores         held-out score of each effect and each pair: log of the error ratio
pairing                 which effects may be tried, alone and in pairs
ranking                 what was tried, best first
plainest                what does as well as the best, and which of these is the plainest
refinement              whether an effect is better than a simpler one, or only fits noise
how it is measured
spectrum_or_trajectory  chooses between the spectrum of the derivative and the trajectory
spectral                residuals of the derivative by frequency, weighted by the noise
shares                  how much an effect matters, in the derivative and in the simulation
chance and noise
p_values                p-value: how often twins give a score as high as the measured one
noise_floor             the residual that sensor noise alone leaves, by frequency band
structure               whether the last residual still depends on the measured variables
alternatives
rivals                  effects that could replace a given one
encompassing            the test of a rival on derivatives
drifting_rivals         the test of a rival on short trajectories
same_model              whether two effects give the same model, written in two ways
results
findings                effects that passed, with their evidence, and the model with them
rejected                the best effect that did not pass
======================  ===================================================================
"""
