"""What an input goes through before it acts: a delay, a lag, a vessel.

`memory_search.py` is where to begin.

======================  ========================================================================
memory_search           finds memories beside all other effects, and tunes them again at the end
probes                  tries a grid of memories, each as one more input of the records
length_and_kind         tunes the length of a memory, and chooses its kind
chains                  a delay and a lag in series, at one input
fine_tuning             refines delays and time constants, and gives their intervals
told from other causes
effect_or_memory        whether an effect explains more than a memory of an input
hold_or_memory          whether an input is held between its samples, or has a memory
======================  ========================================================================
"""
