"""Commands for facades."""
