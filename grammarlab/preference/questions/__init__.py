"""What to ask next, and what an answer can be expected to be."""
