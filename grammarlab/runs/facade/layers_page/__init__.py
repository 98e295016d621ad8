"""A page on which a person sees a design of layers follow its canvas, switches its parts and edits its text."""
