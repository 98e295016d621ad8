"""Runs that sample models."""
