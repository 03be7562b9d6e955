"""The vocabulary: effects that engineers know by name, as columns that an equation may lack.

`vocabulary.py` lists the effects, `missing.py` selects those that a design may lack; the files
between build them, each those of a kind.

=================  ==============================================================================
basis
names              the names of all effects, in the order of preference
vocabulary         all effects with a name that an equation may lack, in their order
missing            which effects a design may lack, and which it has already
candidate          one effect that may be missing, as columns for an equation
shaping            the numbers inside an effect, such as a rate, prepared for tuning
partners           effects in several equations that share the same inner numbers
kinks              expressions with a kink or a jump
forces
frictions          dampings and frictions, of a body or between two
springs            springs and dead zones, of a body or between two
weights            gravity on an angle, and what comes twice a turn
couplings          other states and their products, motion relative to a body or an input
inputs             gains, nonlinearities and saturations of an input
joints             these forces at the joints of an arm
entries            forces that enter through an inverse mass matrix
links              weights and Coriolis forces of the links of an arm, at several joints
inertia            inertias that vary with an angle
angles             forces of rotating bodies, periodic in angles or their difference
radial_forces      forces along or against a motion in a plane or in space
stops              end stops, contacts, slack ropes
flows and changes
differences        flows in proportion to a difference, such as heat between two walls
varying_terms      declared terms whose coefficient changes, with a variable or time
slips              declared sums, such as the slip of a tyre, as forces that level off
saturating_rates   declared rates that saturate with a level
valves             declared inputs that open a valve, whose flow goes with the root of a pressure
with memory
hysteresis         hysteresis, and friction with a rounded sign
relaxation         springs whose force fades, bodies that store heat
flexible_modes     unmeasured masses on springs
followers          both of them: hidden states that follow a measured one
by frequency
lines              frequencies at which the spectrum of a signal stands above the noise
periodic           forcing and ripple at these frequencies
modulation         frequency at which the strength of a term varies
pumped_terms       terms of the model times a wave of the time
rippled_terms      terms of the model times a wave of the position
=================  ==============================================================================
"""
