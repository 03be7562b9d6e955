"""Sparse regression on Gram matrices: supports are proposed, pruned, and one is chosen.

`selection.py` is where to begin; `gram.py` explains the symbols that all files use.

============  =====================================================================
gram          least squares on Gram matrices; the table of symbols
proposals     which terms may belong together, by elastic net and forward selection
beam          best small subsets of nearly collinear columns
elimination   backward elimination by an information criterion
parsimony     drops terms that are significant, but not needed
selection     chooses one equation among all proposals
============  =====================================================================
"""
