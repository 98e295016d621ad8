"""Commands on facades: from files to files."""
