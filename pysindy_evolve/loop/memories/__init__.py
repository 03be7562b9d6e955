"""What an input goes through before it acts: a delay, a lag, a vessel.

`find.py` is where to begin.

======================  ========================================================================
find                    finds memories beside all other effects, and tunes them again in the end
probes                  memories on a grid, each tried as one more input of the records
reach                   tunes how long a memory reaches back, and chooses its kind
chains                  a delay and a lag one after the other, at one input
polish                  the last digits of delays and time constants, and their intervals
told from other causes
effect_or_memory        whether an effect is more than a memory of an input
hold_or_memory          whether an input is held between its samples, and not late
======================  ========================================================================
"""
