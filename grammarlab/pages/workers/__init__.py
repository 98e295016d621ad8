"""Worker processes of a scoring session."""
