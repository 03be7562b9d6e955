"""What an input goes through before it acts, and what follows a measured state."""
