"""Design spaces: designs that have addresses, can be made again, described by numbers and shown."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.derivation.forest import MissingAsset
from grammarlab.errors import UsageError
from grammarlab.features.columns.feature_table import FeatureTable
from grammarlab.features.patterns.pattern import Feature
from grammarlab.language.display_names import DisplayNames
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.settings import POOL_SIZE, FeatureOptions
from grammarlab.scene.instances import Scene

if TYPE_CHECKING:
    from grammarlab.tastes.language import Candidates

Designs = TypeVar("Designs")
"""A batch of n designs, in the representation of a space; for a grammar a `Forest`."""
Designs_contra = TypeVar("Designs_contra", contravariant=True)


class DesignColumns(Protocol[Designs_contra]):
    """The columns of tables, found on some designs and then used for any others."""

    def apply(self, designs: Sequence[Designs_contra], /) -> FeatureTable:
        """Table of batches of designs, one below the other."""
        ...


@dataclass(frozen=True)
class Realized:
    """Designs as meshes."""

    scene: Scene
    """One model per design, in their order."""
    missing_assets: tuple[MissingAsset, ...] = ()
    """Meshes that the asset folder of the space lacks."""


class AbstractParts(ABC):
    """The visible parts of one design, which a person may select."""

    @property
    @abstractmethod
    def of_triangles(self) -> Ints:
        """[T] the part of each triangle of the design's file, from 0; no triangles if parts are unknown."""

    @abstractmethod
    def way_to(self, part: int) -> tuple[tuple[str, str], ...]:
        """Origin of each part, from the whole down to it: names with their places in the file, or empty."""


class NoParts(AbstractParts):
    """Parts of designs without information."""

    @property
    def of_triangles(self) -> Ints:
        return np.zeros(0, dtype=np.int64)

    def way_to(self, part: int) -> tuple[tuple[str, str], ...]:
        return ()


class AbstractDesignSpace(ABC, Generic[Designs]):
    """All designs that a random process can make, each with an address.

    A space has its own density p and a proposal: a density p' that is positive wherever p is, under which designs that
    are rare under p are more frequent. A design of either is a design of the space.
    """

    @property
    @abstractmethod
    def hashes(self) -> tuple[str, str]:
        """Hashes of the space and its proposal in label files.

        Each is the SHA-256 in hexadecimal of all inputs of the designs.
        """

    @property
    @abstractmethod
    def longest_path(self) -> int:
        """Largest length of paths (`FeatureOptions.path_length`); 1 if features have no length."""

    @property
    def pool_size(self) -> int:
        """Number of designs of a usual pool: fewer where making them takes long."""
        return POOL_SIZE

    @property
    def display_names(self) -> DisplayNames:
        """Words in which people read the names of columns."""
        return DisplayNames({}, {}, {})

    def unit_of(self, draw: str) -> str:
        """Unit of a draw by its name, such as ``m``; empty for a plain number, `dimensions.UNKNOWN` for none known."""
        return ""

    @abstractmethod
    def make(self, addresses: Sequence[Address]) -> Designs:
        """Designs by ascending address, without data that only pictures need.

        Raises:
            UsageError: If an address has no design in the space.
        """

    @abstractmethod
    def sample(self, flat: bool, num: int, seed: int, first: int = 0) -> Iterator[Designs]:
        """The designs ``first`` to ``first + num - 1`` of a seed, in batches as from `make`.

        Args:
            flat: whether designs are of the proposal instead of the space itself.
            num: number of designs, >= 0.
            seed: 0 <= seed < 2**64.
            first: index of the first one.
        """

    @abstractmethod
    def log_ratio(self, designs: Designs) -> Floats:
        """[n] log of p / p', for designs of either."""

    @abstractmethod
    def take(self, designs: Designs, indices: Ints) -> Designs:
        """Selected designs of a batch, by ascending index."""

    @abstractmethod
    def vocabulary(self, designs: Sequence[Designs], features: FeatureOptions) -> DesignColumns[Designs]:
        """Columns that distinguish designs."""

    def tabulated(
        self, designs: Sequence[Designs], features: FeatureOptions
    ) -> tuple[DesignColumns[Designs], FeatureTable]:
        """The columns of `vocabulary`, and the table of the same designs."""
        columns = self.vocabulary(designs, features)
        return columns, columns.apply(designs)

    def candidates(self, designs: Sequence[Designs]) -> Candidates:
        """What a person may like about designs: columns of one language, each with a price, whatever the scores are.

        Made of at most a few thousand designs; `values` has the candidates of others.
        """
        # Imported here, since a page shows its first pictures without what learns.
        from grammarlab.tastes.basic_quantities import Elements  # noqa: PLC0415
        from grammarlab.tastes.language import candidates  # noqa: PLC0415

        return candidates(Elements.of_columns({}, len(self.values(designs, ()))))

    @abstractmethod
    def values(self, designs: Sequence[Designs], features: Sequence[Feature]) -> Floats:
        """[n, F] values of features, such as composed columns."""

    def check(self, features: Iterable[Feature]) -> None:
        """Check that designs can have features, such as those that a scenario names.

        Raises:
            UsageError: If a name is unknown; it names the nearest.
        """

    def log_density(self, designs: Designs) -> Floats:
        """[n] log of the density of designs in the space, up to a constant.

        Raises:
            UsageError: If it is unknown for designs of this kind.
        """
        raise UsageError("how likely designs of this kind are is unknown, so they have no uniform base.")

    @abstractmethod
    def realize(self, addresses: Sequence[Address]) -> Realized:
        """Designs by ascending address, as meshes.

        Raises:
            UsageError: If an address has no design in the space.
        """

    def contrast(self, address: Address, feature: Feature) -> Realized | None:
        """A design without and with the choice that a feature looks at, all else equal: two models, as meshes.

        Returns:
            The two; None if the feature is not about one choice, or if the design has no place for it.

        Raises:
            UsageError: If the address has no design in the space.
        """
        return None

    def parts(self, address: Address) -> AbstractParts:
        """The parts of a design."""
        return NoParts()

    def asset_names(self) -> Iterable[str]:
        """Texts that may name files of an asset folder (`grammarlab.runs.sample.checks.named_files`)."""
        return ()

    def scene(self, num: int, seed: int) -> Scene:
        """The designs ``0`` to ``num - 1`` of a seed as meshes."""
        return self.realize([Address(False, seed, model) for model in range(num)]).scene
