"""What the user gives: a declared model, its records, and the rules of the search.

`declared.py` is where to begin; most files of the loop work on its `Design` and on `Segments`.

===============  ========================================================================
the model
declared         the declared model, from text, sympy or a SINDy model
sindy_models     a SINDy model as the declared one
design           a model with free coefficients: known parts and linear columns
inertia          inertias that vary periodically with a position, which divide all forces
kinematics       which states are positions, and which are velocities
algebraic        models of a quantity itself, such as a force, with no derivative
checks
given            model and records, checked and brought to one form
record_checks    what records must fulfill
rules            the settings of the loop
the records
record_split     split of the records into training and held-out ones
resampling       records prepared again at another sampling time or cutoff
smoothing        records whose derivatives were smoothed more than their states
segments         pieces of equal length of the training records, and their frequency band
rows             all variables of records side by side, and expressions evaluated on them
ranges           the range of each variable
the inputs
held             which inputs are held constant between samples
input_functions  functions through which held inputs act, such as a square
input_errors     errors of recorded inputs: sensor noise, changes between samples
the sensors
band             the low-pass of a record, applied to runs of a model too
limits           limits that a reading shows, of the state or of its sensor
sensor           runs seen through a sensor with a limited range
sticking         rows on which a body moves, where the sign of its velocity is known
===============  ========================================================================
"""
