"""Pages in a browser, and the server for them."""

from pathlib import Path

STATIC = Path(__file__).with_name("static")
"""Built pages: one folder per page, with its script and its style."""
