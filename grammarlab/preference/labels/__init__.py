"""What people said, as plain data and as files."""
