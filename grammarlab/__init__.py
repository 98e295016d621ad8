"""Sample real models from stochastic CGA shape grammars."""

__version__ = "0.1.0"
