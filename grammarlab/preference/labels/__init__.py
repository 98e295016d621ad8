"""Labels, as plain data and as files."""
