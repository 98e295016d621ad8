"""Scenes as files: GLB, OBJ with MTL, and PLY."""

from grammarlab.export.save import FORMATS, REUSES, SaveOptions, save, save_each, save_together

__all__ = ["FORMATS", "REUSES", "SaveOptions", "save", "save_each", "save_together"]
