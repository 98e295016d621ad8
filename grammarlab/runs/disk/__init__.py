"""What runs leave on disk: finished results and derivations."""
