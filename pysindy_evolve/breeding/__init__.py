"""What each generation of a search does: terms bred, evaluated, tuned and refitted."""
