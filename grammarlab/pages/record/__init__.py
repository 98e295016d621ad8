"""The record of a scoring session on disk."""
