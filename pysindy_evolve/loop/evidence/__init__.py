"""One step: effects scored on held-out pieces, tested on twins, held against their rivals."""
