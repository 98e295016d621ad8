"""Which version this is, and where it lies."""

from pathlib import Path

__version__ = "0.1.0"

PACKAGE = Path(__file__).parent
"""The folder of the package: with its data inside it where it is installed, beside it in a checkout."""
