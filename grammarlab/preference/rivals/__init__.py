"""Other methods behind the same interface, for comparison."""
