"""Questions to ask next, and the expected answers."""
