"""Design spaces, and designs as rows of numbers."""
