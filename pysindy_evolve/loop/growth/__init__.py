"""Terms that no name fits, grown by genetic programming."""
