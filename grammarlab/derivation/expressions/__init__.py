"""Expressions and sequences of operations, compiled to steps over columns."""
