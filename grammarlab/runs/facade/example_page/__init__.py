"""A page to correct what was found in an example: lines between units, labels, walls; and to try what comes of it."""
