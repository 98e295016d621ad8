"""The rule language CGA; see README.md in this folder."""
