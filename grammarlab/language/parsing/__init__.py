"""Text in, syntax tree and findings out."""
