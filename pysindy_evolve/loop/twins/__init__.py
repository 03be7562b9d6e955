"""Twins: machines in which nothing is missing, and what a statistic is worth among them."""
