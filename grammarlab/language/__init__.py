"""The rule language: CGA text to a checked `grammar.Grammar`, and back."""
