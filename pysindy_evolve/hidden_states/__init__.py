"""Terms and inputs with memory: delays, lags, vessels, hysteresis, relaxation.

==================  ======================================================================
inputs with memory
memory              delays, lags and vessels between an input and its effect
memory_equations    equations with such inputs and with hidden states
terms with memory
path_states         what all kinds below have in common: a hidden state along a path
relaxing            a spring in series with a damper, or a heat capacity not measured
flexible_mode       a mass not measured, coupled by a spring and a damper
boucwen             Bouc-Wen hysteresis of a friction
wen_spring          Bouc-Wen hysteresis of a spring, which loses energy but does not yield
turning             the hidden state of a hysteresis along a path, for the two files above
==================  ======================================================================
"""
