"""What operations and functions are handed."""
