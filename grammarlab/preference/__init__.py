"""Preferences: functions over all models, learned from scores of some. Their input is rows of numbers, not shapes."""

from grammarlab.preference.base import AbstractPreference, Prediction, Relevance
from grammarlab.preference.fitting import Method, fit

__all__ = ["AbstractPreference", "Method", "Prediction", "Relevance", "fit"]
