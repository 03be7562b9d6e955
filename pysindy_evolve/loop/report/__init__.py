"""What the loop says: equations, errors before and after, evidence, pictures, experiments."""
