"""Runs that read, edit and make facades."""
