"""Species of trees as a domain of runs: their parameters are drawn, they grow and get meshes, part by part."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pyarrow as pa
import shapely

from grammarlab.arrays import Floats, Ints
from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.texture_files import image_file
from grammarlab.errors import Finding, LanguageError, Location, TomlError, UsageError
from grammarlab.files import read_bounded
from grammarlab.geometry.footprints.footprint import Footprint, Remark
from grammarlab.language.attribute_values import AttributeValue, length, named_values
from grammarlab.language.grammar import read_text
from grammarlab.randomness import Keys, root_keys, uniforms
from grammarlab.runs.sample.domains import SPECIES, AbstractDomain, CheckedText
from grammarlab.runs.sample.model_rows import ModelRows
from grammarlab.runs.sample.models import AbstractModels, Batch, MadeModels, MadeScene, Report
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.tree_table import FILES, TreeTable
from grammarlab.scene import Scene
from grammarlab.toml_text import toml_text
from grammarlab.trees.accepted_trees import accepted_rows, log_density, rule_of
from grammarlab.trees.arbaro import check_arbaro, read_arbaro, write_arbaro
from grammarlab.trees.crown_reach import CrownReach
from grammarlab.trees.detail import DETAILS, Detail
from grammarlab.trees.growth import grow_chunks
from grammarlab.trees.measures import MEASURES, measure
from grammarlab.trees.parameters import COLUMN, COLUMNS, HIGH, IS_INTEGER, LOW, PARAMETERS, SPREAD
from grammarlab.trees.scene import realize_trees
from grammarlab.trees.skeleton import Skeleton
from grammarlab.trees.species import Species, constrained
from grammarlab.trees.species_file import MAX_CHARACTERS, check, parse, write

if TYPE_CHECKING:
    from grammarlab.learning.designs.species_space import SpeciesSpace
    from grammarlab.learning.targets.species_target import SpeciesWriter

DETAIL = "detail"
"""Attribute of the level of detail; the other attributes are the columns of the parameters."""
ARBARO = ".xml"
"""Suffix of files of Arbaro."""
_HEADING = 0x4845_4144
"""Site of the heading of a planted tree."""
_MAX_NODES = 100_000
"""Largest expected number of nodes of stems in memory at once, a budget: some 200 MB with their meshes and leaves."""
_STRING = re.compile(r'"{3}.*?"{3}|\'{3}.*?\'{3}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'', re.DOTALL)


@dataclass(frozen=True, eq=False)
class SpeciesModels(AbstractModels):
    """Trees of a species."""

    species: Species
    assets: AssetRoot
    """Folder of the pictures of bark and leaves."""

    def attributes(self, texts: Sequence[str]) -> dict[str, AttributeValue]:
        values = named_values(texts, f"scale=12 or {DETAIL}=low")
        return {name: checked_value(name, value) for name, value in values.items()}

    def left_out(self) -> tuple[Finding, ...]:
        return ()

    def check(self, request: SampleRequest) -> None:
        if request.start_rule:
            raise UsageError(f"start rule {request.start_rule!r}: trees have no rules; leave it out.")
        for name, value in request.attributes.items():
            checked_value(name, value)

    def asset_names(self) -> Iterable[str]:
        look = self.species.look
        return tuple(filter(None, (look.bark, look.leaf, look.blossom)))

    def remarks(self, request: SampleRequest) -> tuple[Remark, ...]:
        return tuple(
            Remark(footprint.name, "property", problem)
            for footprint in request.footprints
            for problem in _usable_properties(footprint)[1]
        )

    def crowns(self, seed: int, attributes: Mapping[str, AttributeValue]) -> CrownReach:
        return CrownReach(with_attributes(self.species, attributes), seed)

    def make(self, request: SampleRequest, batch: Batch) -> MadeModels:
        parts = [self._drawn(request, batch, *lot) for lot in _lots(request, batch)]
        table = TreeTable.joined([table for table, _ in parts])
        return MadeModels(
            scenes=(
                MadeScene(scene=scene, shapes=num_parts(skeleton).tolist(), reports=reports_of(measure(skeleton)))
                for skeleton, scene in self._grown(table)
            ),
            log_probability=[density for _, densities in parts for density in densities],
            tries=table.tries.tolist(),
            accepted=table.is_accepted.tolist(),
            save=lambda folder: (table.save(folder), FILES)[1],
        )

    def rows(self, request: SampleRequest, batch: Batch) -> ModelRows:
        parts = [self._drawn(request, batch, *lot) for lot in _lots(request, batch)]
        table = TreeTable.joined([table for table, _ in parts])
        places = {f"position.{axis}": pa.array(table.position[:, k].copy()) for k, axis in enumerate("xyz")}
        parameters = {f"parameter.{name}": pa.array(table.rows[:, k].copy()) for k, name in enumerate(COLUMNS)}
        return ModelRows(
            columns={"kind": pa.array(table.kind), "heading": pa.array(table.heading), **places, **parameters},
            log_density=pa.array([density for _, densities in parts for density in densities], pa.float64()),
            tries=table.tries,
            accepted=table.is_accepted,
        )

    def legend(self) -> dict[str, Any]:
        return {"kinds": [{"weight": kind.weight, "means": kind.means} for kind in self.species.kinds]}

    def stored(self, request: SampleRequest, batch: Batch, folder: Path) -> Iterator[Scene]:
        return (scene for _, scene in self._grown(TreeTable.load(folder)))

    def _drawn(
        self, request: SampleRequest, batch: Batch, models: Ints, footprint: Footprint | None
    ) -> tuple[TreeTable, list[float | None]]:
        """Trees of one footprint, and the log-density of each."""
        properties = {} if footprint is None else _usable_properties(footprint)[0]
        values = {**properties, **request.attributes}
        species = with_attributes(self.species, values)
        trees = accepted_rows(species, root_keys(request.seed, models))
        place = np.zeros(3) if footprint is None else _centroid(footprint)
        if request.stand is not None:
            place = request.stand.position[batch.first_model : batch.first_model + batch.num_models]
        table = TreeTable(
            model=models,
            key=trees.keys,
            kind=trees.kind,
            tries=trees.tries,
            is_accepted=trees.is_accepted,
            detail=(str(values.get(DETAIL, DETAILS[0])),) * len(models),
            heading=_headings(trees.keys) if request.stand is not None else np.zeros(len(models)),
            position=np.broadcast_to(place, (len(models), 3)),
            rows=trees.rows,
        )
        return table, log_density(species, trees.rows).tolist()

    def _grown(self, table: TreeTable) -> Iterator[tuple[Skeleton, Scene]]:
        """Skeletons and scenes of trees, a part of them at a time; a tree does not depend on its part."""
        for part in _alike(table):
            done = 0
            for skeleton in grow_chunks(part.rows, part.key, _MAX_NODES, part.heading):
                scene = realize_trees(skeleton, self.species.look, cast("Detail", part.detail[0]), self.assets)
                done += skeleton.num_trees
                yield skeleton, replace(scene, origins=part.position[done - skeleton.num_trees : done])


class SpeciesDomain(AbstractDomain["SpeciesSpace", SpeciesModels]):
    """Domain of files of species."""

    def read(self, path: Path, library: Path | str | None = None) -> str:
        content = read_bounded(path, 4 * MAX_CHARACTERS)
        try:
            return toml_text(content)
        except TomlError as error:
            place = Location(error.line or 1, error.column or 1, 1, str(path))
            raise LanguageError((Finding("error", "encoding", error.message, place),), "") from error

    def check(self, path: Path, assets: AssetRoot) -> Sequence[CheckedText]:
        text = self.read(path)
        return (_CheckedSpecies(text, _findings(text, str(path), assets)),)

    def formatted(self, text: str, file: str, suffix: str) -> str:
        if suffix == ARBARO:
            return write_arbaro(parse(text, file))
        if suffix != SPECIES:
            return super().formatted(text, file, suffix)
        lines = text.splitlines(keepends=True)
        head = next((i for i, line in enumerate(lines) if not line.startswith("#")), len(lines))
        if "#" in _STRING.sub("", "".join(lines[head:])):
            raise UsageError(
                f"{file}: its canonical form keeps comments at the top only: move the others there, or into `why`."
            )
        return "".join(lines[:head]) + ("\n" if head else "") + write(parse(text, file))

    def open(self, text: str, name: str, assets: AssetRoot) -> SpeciesSpace:
        from grammarlab.learning.designs.species_space import SpeciesSpace  # noqa: PLC0415

        return SpeciesSpace(species_to_run(text, f"{name}{SPECIES}"), text, assets)

    def models(self, text: str, name: str, assets: AssetRoot) -> SpeciesModels:
        return SpeciesModels(species_to_run(text, f"{name}{SPECIES}"), assets)

    def writer(self, space: SpeciesSpace) -> SpeciesWriter:
        # It loads JAX, which drawing does not need.
        from grammarlab.learning.targets.species_target import SpeciesWriter  # noqa: PLC0415

        return SpeciesWriter(space)


class ArbaroDomain(SpeciesDomain):
    """Domain of files of Arbaro, which are read as species."""

    def read(self, path: Path, library: Path | str | None = None) -> str:
        return write(read_arbaro(read_text(path), str(path)))

    def check(self, path: Path, assets: AssetRoot) -> Sequence[CheckedText]:
        text = read_text(path)
        return (_CheckedSpecies(text, check_arbaro(text, str(path))),)

    def formatted(self, text: str, file: str, suffix: str) -> str:
        return super().formatted(write(read_arbaro(text, file)), file, suffix)


@dataclass(frozen=True, slots=True)
class _CheckedSpecies:
    """A `CheckedText`."""

    text: str
    findings: tuple[Finding, ...]


def species_to_run(text: str, file: str) -> Species:
    """The species of a text without errors, with a valid acceptance rule.

    Raises:
        LanguageError: If there are errors; it lists all of them.
    """
    species = parse(text, file)
    problems = _rule_findings(species, text, file)
    if problems:
        raise LanguageError(problems, text)
    return species


def with_attributes(species: Species, values: Mapping[str, AttributeValue]) -> Species:
    """A species in which some columns are constant; the draws of the others do not change.

    Args:
        species: the species.
        values: values by the name of the column, see `checked_value`; `DETAIL` is ignored.
    """
    return constrained(species, {name: checked_value(name, value) for name, value in values.items() if name != DETAIL})


def checked_value(name: str, value: AttributeValue) -> float | str:
    """The value of an attribute of trees: of a column of the parameters, or the level of detail.

    Args:
        name: a name of `COLUMNS`, or `DETAIL`.
        value: the value, or its text; lengths may have units.

    Raises:
        UsageError: If there is no such attribute, or it cannot have the value.
    """
    if name == DETAIL:
        if value not in DETAILS:
            raise UsageError(f"attribute {name!r}: expected one of {', '.join(DETAILS)}, found {str(value)[:60]!r}.")
        return str(value)
    if name not in COLUMN:
        near = get_close_matches(name.lower(), (*COLUMNS, DETAIL), n=1, cutoff=0.5)
        hint = f" Did you mean {near[0]!r}?" if near else ""
        raise UsageError(
            f"unknown attribute {name[:60]!r}.{hint} Attributes of trees are their parameters, which `grammarlab show` "
            f"lists, their spreads, such as 'scale{SPREAD}', and {DETAIL!r}."
        )
    column = COLUMN[name]
    parameter = PARAMETERS[name if name in PARAMETERS else name.removesuffix(SPREAD)]
    number = _number(value, parameter.unit)
    kind = "a whole number from" if IS_INTEGER[column] else ""
    if number is None or not LOW[column] <= number <= HIGH[column] or (kind and number != round(number)):
        limits = f"{LOW[column]:g} to {HIGH[column]:g} {parameter.unit}".rstrip()
        raise UsageError(f"attribute {name!r}: expected {kind} {limits}, found {str(value)[:60]!r}.".replace("  ", " "))
    return number


def num_parts(skeleton: Skeleton) -> Ints:
    """[n] number of stems and leaves of each tree."""
    columns = [level.tree for level in skeleton.levels] + [skeleton.leaves.tree]
    return np.sum([np.bincount(tree, minlength=skeleton.num_trees) for tree in columns], axis=0)


def reports_of(measures: Floats) -> list[Report]:
    """Measures [n, M] of trees as reports of models."""
    return [
        {name: {"count": 1, **dict.fromkeys(("sum", "mean", "min", "max"), value)} for name, value in entries}
        for entries in (zip(MEASURES, row, strict=True) for row in measures.tolist())
    ]


def _number(value: AttributeValue, unit: str) -> float | None:
    """A finite number; None for other values."""
    if isinstance(value, bool):
        return None
    if isinstance(value, str):
        try:
            number = float(value)
        except ValueError:
            metres = length(value) if unit == "m" else None
            if metres is None:
                return None
            number = metres
    else:
        number = float(value)
    return number if np.isfinite(number) else None


def _findings(text: str, name: str, assets: AssetRoot) -> tuple[Finding, ...]:
    """Findings about a species, its acceptance rule and its pictures."""
    findings = check(text, name)
    if any(finding.severity == "error" for finding in findings):
        return findings
    species = parse(text, name)
    missing = (
        Finding(
            "warning",
            "missing-asset",
            f'there is no picture "{picture}" in the asset folder {assets}; its colour stands in its place',
            _place_of(key, text, name),
            "say where the pictures are with `assets=DIR`",
        )
        for key in ("bark", "leaf", "blossom")
        if (picture := getattr(species.look, key)) and image_file(picture, assets) is None
    )
    return (*findings, *_rule_findings(species, text, name), *missing)


def _rule_findings(species: Species, text: str, file: str) -> tuple[Finding, ...]:
    try:
        rule_of(species.acceptance)
    except UsageError as error:
        return (Finding("error", "bad-acceptance", str(error), _place_of("acceptance", text, file)),)
    return ()


def _place_of(key: str, text: str, file: str) -> Location:
    """The line that gives a value to a key."""
    match = re.search(rf"^[ \t]*{key}[ \t]*=", text, re.MULTILINE)
    return Location(text.count("\n", 0, match.start()) + 1 if match else 1, 1, len(key), file)


def _usable_properties(footprint: Footprint) -> tuple[dict[str, AttributeValue], tuple[str, ...]]:
    """Properties of a footprint that are attributes of trees, and messages about values that these cannot have."""
    values: dict[str, AttributeValue] = {}
    problems = [f"attribute {name!r}: expected a number" for name in footprint.unread if name in COLUMN]
    for name, value in footprint.properties.items():
        if name in COLUMN or name == DETAIL:
            try:
                values[name] = checked_value(name, value)
            except UsageError as error:
                problems.append(str(error).rstrip("."))
    return values, tuple(problems)


def _lots(request: SampleRequest, batch: Batch) -> Iterator[tuple[Ints, Footprint | None]]:
    """Indices of the models of a batch on each footprint."""
    first, end = batch.first_model, batch.first_model + batch.num_models
    if request.stand is not None:
        yield request.stand.model[first:end].astype(np.int64), None
        return
    if not request.footprints:
        yield np.arange(first, end), None
        return
    for number in range(first // request.num_models, (end - 1) // request.num_models + 1):
        low, high = max(first, number * request.num_models), min(end, (number + 1) * request.num_models)
        yield np.arange(low, high), request.footprints[number]


def _headings(keys: Keys) -> Floats:
    """[n] radians by which the trees of a stand are turned, each by its own draw."""
    return 2.0 * np.pi * uniforms(keys, _HEADING)


def _centroid(footprint: Footprint) -> Floats:
    """Where a tree stands on a footprint [3], metres."""
    corners = footprint.polygon
    origin = corners[0]  # far from the origin of the world, areas of small polygons have few digits
    centre = shapely.centroid(shapely.Polygon((corners - origin)[:, [0, 2]]))
    return origin + np.array([centre.x, 0.0, centre.y])


def _alike(table: TreeTable) -> Iterator[TreeTable]:
    """Consecutive trees of one level of detail."""
    start = 0
    for _, run in groupby(table.detail):
        end = start + len(list(run))
        yield table.part(start, end)
        start = end
