"""Sparse regression on Gram matrices: what is proposed, pruned and chosen."""
