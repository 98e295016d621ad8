"""The rule language: from CGA text to a checked `grammar.Grammar`, and back."""
