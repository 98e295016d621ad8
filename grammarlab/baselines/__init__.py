"""The paper's own preference and other methods, for comparison."""
