"""The loop of learning; see README.md in this folder."""
