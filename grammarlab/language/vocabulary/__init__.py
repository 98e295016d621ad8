"""What CGA has of its own: operations, functions, attributes, keywords and types."""
