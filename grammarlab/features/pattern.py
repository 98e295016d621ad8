"""Tree patterns: what a countable property of a derivation tree is.

Paths, symbol counts, skip-bigrams, adjacent siblings and subtrees are all patterns; they differ in shape only. A model
is described by how often each pattern occurs in its tree, counted by embeddings: the number of ways to lay the
pattern's nodes on nodes of the tree.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Pattern:
    """A node of the tree, and what stands below it."""

    symbol: str | None = None
    """The symbol that the node must have; None for any."""
    parameters: int | None = None
    """How many parameters its rule must have; None for any."""
    branch: tuple[int, ...] | None = None
    """How the branch that rewrote it must begin (`RuleName.branch`); None for any node, rewritten or leaf. The empty
    tuple asks for a node that some rule rewrote."""
    below: tuple[Below, ...] = ()
    """Conditions that hold side by side; the numbers of ways to fulfil them are multiplied."""


@dataclass(frozen=True, slots=True)
class Below:
    """A run of adjacent siblings below a node; the ways to find one are added up.

    Siblings are ordered by ``child``, then by ``repeat``.
    """

    run: tuple[Pattern, ...]
    """At least one; each next one matches the next sibling."""
    place: int | None = None
    """``child`` of the first of the run; None for any."""
    deep: bool = False
    """Whether the run may stand anywhere below the node, not only directly."""


@dataclass(frozen=True, slots=True)
class Threshold:
    """How many draws of one random expression lie below a bound."""

    site: str
    """The random expression, by the name that `Forest.sites` gives it: the attribute's name for an attribute."""
    bound: float


@dataclass(frozen=True, slots=True)
class Draw:
    """The mean of the draws of one random expression in a model; 0 where there is none.

    For a choice, ``branch`` says which branch, and the value is how often it was taken.
    """

    site: str
    branch: int | None = None


Feature = Pattern | Threshold | Draw
