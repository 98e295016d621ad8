"""CGA's roofs: plans from straight skeletons, and formulas for simple cases."""
