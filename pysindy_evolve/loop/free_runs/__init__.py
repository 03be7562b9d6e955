"""What only free runs of a model show: slow memories, limits, effects that change places."""
