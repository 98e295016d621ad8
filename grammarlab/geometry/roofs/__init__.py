"""CGA's roofs: plans from straight skeletons, and formulas where there is no need of one."""
