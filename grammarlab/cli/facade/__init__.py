"""Commands on facades."""
