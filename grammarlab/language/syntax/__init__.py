"""The syntax tree of a rule file, over which everything walks, and its text."""
