"""Warnings about parameters of a species that contradict each other."""

from __future__ import annotations

from grammarlab.errors import Finding
from grammarlab.trees.species import Species


def contradictions(species: Species, text: str, name: str) -> tuple[Finding, ...]:
    """Warnings about a species.

    Args:
        species: the species of a file.
        text: the whole file.
        name: its name, for messages.
    """
    del species, text, name
    return ()
