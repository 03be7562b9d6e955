"""What the user gives: a declared model, its records, and the rules of the search."""
