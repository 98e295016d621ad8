"""Features of derivation trees, and tables of them; see README.md in this folder."""

from grammarlab.features.columns.feature_table import FeatureTable as FeatureTable
from grammarlab.features.columns.vocabulary import Options as Options
from grammarlab.features.columns.vocabulary import Vocabulary as Vocabulary
from grammarlab.features.columns.vocabulary import extract as extract
from grammarlab.features.patterns.counts import count as count
