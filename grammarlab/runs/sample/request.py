"""Request of a run: all inputs that determine its files, and nothing else."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, Self, TypedDict, Unpack, get_args

import numpy as np

from grammarlab.asset_roots import AssetRoot
from grammarlab.derivation.lots import shared_origin
from grammarlab.errors import AssetError, UsageError
from grammarlab.export import FORMATS
from grammarlab.export.save import Format
from grammarlab.geometry.footprints.footprint import Footprint, FootprintMap, Georeference, Remark
from grammarlab.language.attribute_values import AttributeValue
from grammarlab.language.grammar import hash_of
from grammarlab.language.presets import RuleChoices
from grammarlab.rendering.choice import RendererName
from grammarlab.runs.sample.domains import DEFAULT, opened_models
from grammarlab.runs.sample.shipped import find_rules
from grammarlab.runs.sample.stand import Stand
from grammarlab.runs.work.json_members import member, numbers, of_kind, plain_values
from grammarlab.scene.pivots import PIVOTS, Pivot

Instancing = Literal["none", "nodes", "gpu"]
Scale = Literal["same", "each"]

MAX_MODELS = 10**12
"""Largest number of models of a run."""
MAX_CHOSEN = 10_000
"""Largest number of chosen models: each may be a batch of its own, with a folder and a record."""


class RequestOptions(TypedDict, total=False):
    """Options of a request; see `SampleRequest`."""

    num_models: int
    models: tuple[int, ...]
    seed: int
    attributes: Mapping[str, AttributeValue]
    start_rule: str
    file_format: Format
    single_file: bool
    instancing: Instancing
    image: bool
    columns: int
    renderer: RendererName
    scale: Scale
    pivot: Pivot


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleRequest:
    """A request of a run. Equal requests make equal files, bit for bit, with equal versions of all libraries.

    >>> from pathlib import Path
    >>> import grammarlab as gl
    >>> request = gl.SampleRequest(name="tower", text="Lot --> extrude(3) Tower", assets=Path(), num_models=4)
    >>> request.num_models
    4
    """

    name: str
    """Name of the files: ``building`` gives ``building-00017.glb``."""
    text: str
    """Text of the file that describes the models."""
    suffix: str = DEFAULT
    """Suffix of its domain (`grammarlab.runs.sample.domains`)."""
    assets: AssetRoot
    """Folder of the assets that it names."""
    num_models: int = 1
    """Number of models per footprint, at least 1."""
    models: tuple[int, ...] = ()
    """Numbers of the models to make, ascending, each as it is in the whole run; empty for all of them."""
    seed: int = 0
    """0 .. 2**64 - 1."""
    attributes: Mapping[str, AttributeValue] = field(default_factory=dict)
    """Values that replace those in the file."""
    start_rule: str = ""
    """Start symbol; empty for that of the rule file."""
    footprints: tuple[Footprint, ...] = ()
    """Footprints of the models; empty for the default footprint."""
    stand: Stand | None = None
    """Trees on an area, which are the models of the run; None for models on footprints."""
    file_format: Format = "glb"
    single_file: bool = False
    """One file with all models instead of one each."""
    instancing: Instancing = "none"
    """Instances in GLB: ``none`` merges by material, ``nodes`` shares meshes, ``gpu`` uses EXT_mesh_gpu_instancing."""
    image: bool = True
    """Whether to draw the contact sheet."""
    columns: int = 0
    """Number of columns of the sheet; 0 for about a square."""
    renderer: RendererName = "cast"
    """Renderer of the sheet: ``cast`` is ray casting, with the same picture on every machine; ``gl`` is OpenGL;
    ``auto`` is OpenGL if it works. The manifest records the used renderer."""
    scale: Scale = "each"
    """Whether the models on the sheet are all to one scale, or ``each`` fills its picture."""
    pivot: Pivot = "world"
    """Where the coordinates of each model count from (`grammarlab.scene.pivots`)."""
    georeference: Georeference | None = None
    """Place of the footprints on the earth; None if it is unknown. It does not change the models."""
    remarks: tuple[Remark, ...] = ()
    """What is left out of the footprints. They do not change the models."""
    origin: tuple[float, float, float] | None = field(init=False, repr=False)
    """Origin [3] in world metres that all files of the run share; None if all footprints are near that of the world."""

    def __post_init__(self) -> None:
        origin = _shared_origin(self.footprints, self.georeference)
        if self.stand is not None:
            origin = _origin_of_stand(self.stand, self.georeference)
        object.__setattr__(self, "origin", origin)
        if not re.fullmatch(r"[\w .,+@-]{1,100}", self.name) or self.name.startswith("."):
            raise UsageError(f"{self.name!r} cannot name files: expected letters, digits, spaces and . , + @ - _ only.")
        if not re.fullmatch(r"\.\w{1,32}", self.suffix):
            raise UsageError(f"{self.suffix!r} is not the suffix of a file: expected one such as {DEFAULT!r}.")
        _check_range("number of models", self.num_models * max(len(self.footprints), 1), 1, MAX_MODELS)
        object.__setattr__(self, "models", _checked_models(self.models, self.num_models * max(len(self.footprints), 1)))
        _check_range("seed", self.seed, 0, 2**64 - 1)
        if self.stand is not None:
            if self.footprints:
                raise UsageError("trees stand on an area or on footprints: give one of them.")
            _check_range("number of models", self.num_models, len(self.stand), len(self.stand))
        _check_range("number of columns", self.columns, 0, 1000)
        _check_choice("format", self.file_format, FORMATS)
        _check_choice("instancing", self.instancing, get_args(Instancing))
        _check_choice("pivot", self.pivot, PIVOTS)
        _check_choice("scale", self.scale, get_args(Scale))
        _check_choice("renderer", self.renderer, get_args(RendererName))
        if self.instancing != "none" and self.file_format != "glb":
            raise UsageError(f"instancing {self.instancing!r} needs format 'glb', found {self.file_format!r}.")

    @classmethod
    def of(
        cls,
        grammar: str | Path,
        *,
        footprint: str = "",
        on: str = "",
        density: float | None = None,
        gap: float = 0.0,
        assets: Path | None = None,
        library: Path | None = None,
        style: str = "",
        **options: Unpack[RequestOptions],
    ) -> Self:
        """A request for a file that describes models, or a shipped example.

        Args:
            grammar: a path, or a name from ``grammarlab list``.
            footprint: footprint in the syntax of `read_footprints`; empty for the default footprint.
            on: an area to plant with trees, in the same syntax. Of `num_models`, as many stand on it as fit, at places
                that depend on the seed and not on the outline.
            density: trees per hectare of a large area, instead of a number; with a number, at most so many. A larger
                area of the same density keeps the trees of a smaller one.
            gap: metres between the crowns of these trees; negative if they may reach into each other.
            assets: folder of assets, by default the one beside the file.
            library: folder of further projects that a rule file imports from.
            style: style of a rule file, instead of its default style.
            **options: the other fields of this class.
        """
        source = find_rules(str(grammar), assets, RuleChoices(library, style))
        text = source.text()
        if on and footprint:
            raise UsageError("trees stand on an area or on footprints: give one of them.")
        if on:
            models = opened_models(source.suffix, text, source.name, source.assets)
            seed = options.get("seed", 0)
            crowns = models.crowns(seed, options.get("attributes", {}))
            from grammarlab.runs.sample.plantation import planted_on  # noqa: PLC0415  # reads maps

            plantation = planted_on(on, crowns, seed, density=density, limit=options.get("num_models"), gap=gap)
            return cls(
                name=source.name,
                suffix=source.suffix,
                text=text,
                assets=source.assets,
                stand=plantation.stand,
                georeference=plantation.georeference,
                remarks=plantation.remarks,
                **(options | {"num_models": len(plantation.stand)}),
            )
        if density is not None or gap != 0.0:
            raise UsageError("density and gap are those of trees on an area: say which with --on.")
        plan = _plan(footprint) if footprint else FootprintMap(())
        return cls(
            name=source.name,
            suffix=source.suffix,
            text=text,
            assets=source.assets,
            footprints=plan.footprints,
            georeference=plan.georeference,
            remarks=plan.remarks,
            **options,
        )

    @property
    def text_hash(self) -> str:
        """SHA-256 of the text in hexadecimal: `Grammar.hash`."""
        return hash_of(self.text)

    @property
    def sheet_name(self) -> str:
        """Name of the file with pictures of all models."""
        return f"{self.name}.png"

    @property
    def plan_name(self) -> str:
        """Name of the file with the plan of a stand of trees."""
        return f"{self.name}_plan.png"

    @property
    def is_in_place(self) -> bool:
        """Whether models keep their places in the world: trees of a stand, or one model on each footprint."""
        return self.stand is not None or (len(self.footprints) > 0 and self.num_models == 1)

    @property
    def model_numbers(self) -> Sequence[int]:
        """Numbers of the models of the run, ascending: model k on footprint f has the number ``f * num_models + k``."""
        return self.models or range(self.num_models * max(len(self.footprints), 1))

    @property
    def total_models(self) -> int:
        """Number of models that the run makes, on all footprints."""
        return len(self.model_numbers)

    def as_json(self) -> dict[str, Any]:
        """All fields that define the models and files as plain values, except the text and the asset folder."""
        return {
            "name": self.name,
            "suffix": self.suffix,
            "num_models": self.num_models,
            "seed": self.seed,
            "attributes": dict(self.attributes),
            "start_rule": self.start_rule,
            "footprints": [
                {"polygon": f.polygon.tolist(), "properties": dict(f.properties), "name": f.name}
                | ({"unread": list(f.unread)} if f.unread else {})
                for f in self.footprints
            ],
            "file_format": self.file_format,
            "single_file": self.single_file,
            "instancing": self.instancing,
            "image": self.image,
            "columns": self.columns,
            "renderer": self.renderer,
            "scale": self.scale,
            **({} if self.pivot == "world" else {"pivot": self.pivot}),
            **({"models": list(self.models)} if self.models else {}),
            **({} if self.stand is None else {"stand": self.stand.as_json()}),
        }

    @classmethod
    def from_json(cls, values: Mapping[str, Any], text: str, assets: AssetRoot) -> Self:
        """Request from the values of `as_json`.

        Raises:
            AssetError: If the values are not those of a request.
        """
        try:
            return cls(text=text, assets=assets, **_fields(values))
        except (TypeError, UsageError, AssetError) as error:
            raise AssetError(f"the manifest does not describe a run of this version: {error}") from error


_TYPES: Mapping[str, type] = {
    "name": str,
    "suffix": str,
    "num_models": int,
    "seed": int,
    "attributes": dict,
    "start_rule": str,
    "footprints": list,
    "file_format": str,
    "single_file": bool,
    "instancing": str,
    "image": bool,
    "columns": int,
    "renderer": str,
    "scale": str,
    "pivot": str,
    "models": list,
    "stand": dict,
}
"""Members of `SampleRequest.as_json`; earlier versions have fewer."""
_MAX_COORDINATE = 1e8
"""Largest coordinate of a footprint, metres: coordinates of maps on Earth are smaller."""


def _fields(values: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of a request from the values of `SampleRequest.as_json`."""
    where = "request"
    unknown = [name for name in values if name not in _TYPES]
    if unknown:
        raise AssetError(f"{where}: unknown member {unknown[0]!r:.60}, perhaps of a newer version of grammarlab.")
    fields: dict[str, Any] = {name: member(values, name, _TYPES[name], where) for name in values}  # ty: ignore[invalid-argument-type]
    fields["attributes"] = plain_values(fields.get("attributes", {}), f"{where}.attributes")
    footprints = enumerate(fields.get("footprints", []))
    fields["models"] = tuple(of_kind(number, int, f"{where}.models") for number in fields.get("models", []))
    fields["footprints"] = tuple(_footprint(entry, f"{where}.footprints[{index}]") for index, entry in footprints)
    if "stand" in fields:
        fields["stand"] = Stand.from_json(fields["stand"], f"{where}.stand")
    return fields


def _footprint(values: Any, where: str) -> Footprint:
    """A footprint of `SampleRequest.as_json`."""
    corners = member(values, "polygon", list, where)
    polygon = np.array([numbers(corner, 3, f"{where}.polygon") for corner in corners]).reshape(-1, 3)
    if len(polygon) < 3 or np.abs(polygon).max() > _MAX_COORDINATE:
        raise AssetError(f"{where}.polygon: expected at least 3 corners within {_MAX_COORDINATE:,.0f} m of the origin.")
    properties = plain_values(member(values, "properties", dict, where), f"{where}.properties")
    unread = of_kind(values.get("unread", []), list, f"{where}.unread")
    names = tuple(of_kind(name, str, f"{where}.unread") for name in unread)
    return Footprint(polygon, properties, member(values, "name", str, where), names)


def _plan(footprint: str) -> FootprintMap:
    from grammarlab.geometry.footprints.footprint_text import read_footprint_map  # noqa: PLC0415  # reads maps

    return read_footprint_map(footprint)


def _shared_origin(
    footprints: tuple[Footprint, ...], georeference: Georeference | None
) -> tuple[float, float, float] | None:
    """See `SampleRequest.origin`; with a longitude and a latitude it is their point, which is that of the world."""
    if not footprints:
        return None
    low, high = (np.array([f(footprint.polygon, axis=0) for footprint in footprints]) for f in (np.min, np.max))
    origin = shared_origin(low, high)
    if origin is None:
        return None
    x, y, z = (origin if georeference is None or georeference.longitude is None else np.zeros(3)).tolist()
    return x, y, z


def _origin_of_stand(stand: Stand, georeference: Georeference | None) -> tuple[float, float, float]:
    """See `SampleRequest.origin`; near the origin of the world it is this one."""
    far = shared_origin(stand.position, stand.position)
    x, y, z = (np.zeros(3) if far is None or (georeference and georeference.longitude is not None) else far).tolist()
    return x, y, z


def read_model_numbers(text: str, num_models: int = MAX_MODELS, whose: str = "the run") -> tuple[int, ...]:
    """Numbers of models of a run, ascending, from a text such as ``3,7,9-12``.

    Args:
        text: numbers, and ranges that include their ends.
        num_models: number of models of the run.
        whose: the run, for messages.

    Raises:
        UsageError: If it is another text, names a model that the run lacks, or more than `MAX_CHOSEN`.

    >>> read_model_numbers("7,3,9-12", 16)
    (3, 7, 9, 10, 11, 12)
    """
    numbers: set[int] = set()
    for part in text.split(","):
        match = re.fullmatch(r"\s*([0-9]{1,13})\s*(?:-\s*([0-9]{1,13})\s*)?", part)
        if match is None:
            raise UsageError(f"models: expected numbers such as 3,7,9-12, found {part!r:.40}.")
        first, last = int(match[1]), int(match[2] or match[1])
        if first > last:
            raise UsageError(
                f"models: expected the smaller number first, as in {last}-{first}, found {part.strip()!r}."
            )
        if last >= num_models:
            raise UsageError(f"models: {whose} has the models 0 to {num_models - 1:,}, found {part.strip()!r}.")
        if len(numbers) + last - first >= MAX_CHOSEN:
            raise UsageError(f"models: expected at most {MAX_CHOSEN:,} of them, found {part.strip()!r} and others.")
        numbers.update(range(first, last + 1))
    return tuple(sorted(numbers))


def _checked_models(models: Sequence[int], num_models: int) -> tuple[int, ...]:
    """Chosen models, each once and ascending."""
    if len(models) > MAX_CHOSEN:
        raise UsageError(f"models: expected at most {MAX_CHOSEN:,} of them, found {len(models):,}.")
    for number in models:
        if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < num_models:
            raise UsageError(
                f"models: the run has the models 0 to {num_models - 1:,}, found {number!r}. A larger `num_models=` has "
                "more; of a seed they begin with the same ones."
            )
    return tuple(sorted(set(models)))


def _check_range(what: str, value: int, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise UsageError(f"{what}: expected a whole number from {low} to {high}, found {value!r}.")


def _check_choice(what: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise UsageError(f"{what}: expected one of {', '.join(choices)}, found {value!r}.")
