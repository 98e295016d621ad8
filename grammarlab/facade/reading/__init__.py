"""Readers of facades in other formats: each makes a `BoxAnnotation` from the content of a file."""
