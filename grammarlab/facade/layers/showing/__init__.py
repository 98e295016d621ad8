"""Views of solved layouts: facades, scenes, grammars."""
