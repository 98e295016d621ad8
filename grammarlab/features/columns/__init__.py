"""Tables of features: a row a model, a column a feature."""
