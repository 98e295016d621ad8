"""Gaussian processes: kernels, evidence, posteriors, and labels of other kinds."""
