"""Expressions over features in scenario and rule files: scores and acceptance."""
