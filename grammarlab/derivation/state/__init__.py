"""All shapes under derivation, as columns, and what a derivation fills."""
