"""The vocabulary: effects that engineers know by name, as columns that may be missing."""
