"""The page of a scoring session."""
