"""What can be counted and measured on derivation trees, and tables of it; see README.md in this folder."""

from grammarlab.features.counting import count as count
from grammarlab.features.table import FeatureTable as FeatureTable
from grammarlab.features.vocabulary import Options as Options
from grammarlab.features.vocabulary import Vocabulary as Vocabulary
from grammarlab.features.vocabulary import extract as extract
