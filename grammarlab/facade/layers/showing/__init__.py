"""What solved layouts look like: facades, scenes, grammars."""
