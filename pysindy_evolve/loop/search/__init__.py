"""The search for what a model lacks: its state, its looks, and their order."""
