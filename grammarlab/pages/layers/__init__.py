"""The page of a design of layers."""
