"""Runs of cities: from a plan to a folder with tiles, tables of parcels and buildings."""
