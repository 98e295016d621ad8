"""Preferences: from scores of some models to a function over all of them. It sees rows of numbers, never shapes."""

from grammarlab.preference.base import AbstractPreference, Prediction, Relevance
from grammarlab.preference.fitting import Method, fit

__all__ = ["AbstractPreference", "Method", "Prediction", "Relevance", "fit"]
