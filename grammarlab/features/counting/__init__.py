"""How often patterns occur in all models of a forest."""
