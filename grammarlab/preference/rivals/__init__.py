"""Other methods with the same interface, for comparison."""
