"""What remembers inputs and states: delays, lags, vessels, hysteresis, relaxation."""
