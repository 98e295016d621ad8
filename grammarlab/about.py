"""Version and folder of the package."""

from pathlib import Path

__version__ = "0.1.0"

PACKAGE = Path(__file__).parent
"""Folder of the package. Its data is inside it if it is installed, and beside it in a checkout."""
