"""Which elements are of one kind, and which sizes kinds share."""
