"""Preferences: functions over all models, learned from scores of some. Their input is rows of numbers, not shapes."""

from grammarlab.preference.base import AbstractPreference, Prediction, Relevance

__all__ = ["AbstractPreference", "Prediction", "Relevance"]
