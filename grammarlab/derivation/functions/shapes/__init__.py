"""What a rule can ask of the shape it is applied to."""
