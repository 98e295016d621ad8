"""Search for features that explain scores."""
