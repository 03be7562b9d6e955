"""The search for what a model lacks: its looks, their order, and what they have found.

`look_for_effects.py` is where to begin. It looks at names, at names again where inputs turn out to
be held, at runs, at grown terms, and then holds all that was found against runs.

===================  ============================================================================
look_for_effects     calls all looks in their order, and begins again where it must
found                what a search has found so far, and the records as they look with it
looks
look_at_names        names of the vocabulary, and memories of inputs
how_inputs_act       inputs that turn out to be held between samples, or to act through functions
look_at_runs         what has a name, or remembers, and shows in nothing but free runs
look_at_grown_terms  terms without a name, where no name explains what is left
hold_against_runs    all that was found held against free runs, and what these show besides
===================  ============================================================================

A look takes what was `Found`, and yields what is known after each of its steps, so that an
interrupt leaves the last of them. `Found` does not change; only what `Grown` remembers is shared,
as growing takes long.
"""
