"""Sparse regression on Gram matrices: what is proposed, pruned and chosen.

`selection.py` is where to begin; `gram.py` explains the symbols that all files use.

============  =====================================================================
gram          least squares on Gram matrices; the table of symbols
proposals     which terms may belong together, by elastic net and forward selection
beam          best small subsets of columns that are alike
elimination   drops one term after the other, as an information criterion says
parsimony     drops terms that are significant, but not needed
selection     the equation that is chosen of all that were proposed
independence  how many independent samples a residual holds
============  =====================================================================
"""
