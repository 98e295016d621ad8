"""Features that explain scores, searched for."""
