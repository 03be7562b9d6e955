"""Terms and inputs with memory: delays, lags, vessels, hysteresis, relaxation.

==================  ======================================================================
inputs with memory
memory              delays, lags and vessels between an input and its effect
memory_equations    equations with such inputs and with hidden states
terms with memory
path_states         the interface of all kinds below: hidden states that follow a measured one
relaxing            a spring in series with a damper, or an unmeasured heat capacity
flexible_mode       an unmeasured mass, coupled by a spring and a damper
boucwen             Bouc-Wen hysteresis of a friction
wen_spring          Bouc-Wen hysteresis of a spring, which loses energy but does not yield
turning             the hidden state of both hystereses, computed along a path
==================  ======================================================================
"""
