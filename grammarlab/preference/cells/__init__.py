"""Preferences that divide designs into cells."""
