"""New buildings from examples, as files."""
