"""A second look at what was found: exchanged, tuned again, or dropped."""
