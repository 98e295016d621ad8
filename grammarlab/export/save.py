"""Saving scenes: all models in one file, or each in its own."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from grammarlab.asset_roots import AssetRoot
from grammarlab.errors import UsageError, check_type
from grammarlab.export.model_files import AbstractWriter, Output, whole_file
from grammarlab.extras import require
from grammarlab.scene import Scene, TriangleBatch, triangles
from grammarlab.scene.instances import require_proper, scene_of_model
from grammarlab.scene.layout import SceneLayout, around, grid, in_place, model_bounds
from grammarlab.scene.pivots import PIVOTS, Pivot, at_pivot

Format = Literal["glb", "obj", "ply", "usd", "usdz", "stl", "3mf"]
Reuse = Literal["merged", "nodes", "instancing"]
FORMATS: tuple[str, ...] = get_args(Format)
HAVE_NODES = ("glb", "usd", "usdz")
"""Formats whose files have their places in the world in 64 bits, so that each file can count from its own model."""
REUSES: tuple[str, ...] = get_args(Reuse)


@dataclass(frozen=True, slots=True)
class SaveOptions:
    """Options of writing files.

    >>> import grammarlab as gl
    >>> gl.SaveOptions(columns=4).columns
    4
    """

    reuse: Reuse = "merged"
    """Reuse of meshes in GLB: one primitive per material (``merged``, the fastest to draw), one node per shape that
    refers to shared meshes (``nodes``, the easiest to edit), or ``instancing`` with EXT_mesh_gpu_instancing (the
    smallest; readers without the extension refuse the file)."""
    assets: AssetRoot | None = None
    """Folder that textures are relative to; None leaves textures out."""
    columns: int | None = None
    """Number of columns if several models share a file; None for about a square."""
    in_place: bool = False
    """Whether models keep their places in the world: those that share a file, instead of a grid, and those that count
    from their pivots, instead of having these at the origin of their files."""
    origin: tuple[float, float, float] | None = None
    """Origin [3] of files in world metres. By default each file far from the origin of the world has its own. Files of
    one model have it if they are OBJ or PLY; a GLB has a node with its own, so its place in the world is exact."""
    pivot: Pivot = "world"
    """Where the coordinates of each model count from: ``world``, the middle of its ``footprint``, or its ``centre``.
    With ``local`` they count from `origin`, and the file names it without moving its models there, for programs whose
    places have 32 bits."""

    def __post_init__(self) -> None:
        if self.pivot not in PIVOTS:
            raise UsageError(f"unknown pivot {self.pivot!r}; choose one of {', '.join(PIVOTS)}")
        if self.reuse not in REUSES:
            raise UsageError(f"unknown reuse {self.reuse!r}; choose one of {', '.join(REUSES)}")
        if self.columns is not None and self.columns < 1:
            raise UsageError(f"columns is {self.columns}; expected at least 1")


def _ignore(_file: Path) -> None:
    """Do nothing with the path of a written file."""


def save(
    scene: Scene, path: str | os.PathLike[str], file_format: Format | None = None, options: SaveOptions | None = None
) -> Path:
    """Write all models of a scene into one file; several models are placed on a grid.

    Args:
        scene: a scene with at least one model.
        path: the file; an OBJ puts its MTL and images beside it.
        file_format: ``glb``, ``obj``, ``ply``, ``usd``, ``usdz``, ``stl`` or ``3mf``; by default from the suffix of
            `path`.
        options: the options.

    Returns:
        The path of the file, which exists only when it is complete.

    Raises:
        UsageError: If the format is unknown, or the path cannot be written to.
        DerivationError: If a coordinate of the scene is not finite.
        AssetError: If a texture is outside the asset folder, or broken.

    >>> import grammarlab as gl
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> scene = gl.realize(gl.derive(gl.Grammar.parse("Lot --> extrude(3) Tower"), 4, seed=1))
    >>> with TemporaryDirectory() as folder:
    ...     gl.save(scene, Path(folder) / "towers.glb").stat().st_size > 500
    True
    """
    check_type("scene", scene, Scene, "gl.realize(forest)")
    target = Path(path)
    options = options or SaveOptions()
    scene = at_pivot(scene, options.pivot)
    chosen = file_format or target.suffix.lstrip(".").lower()
    return _save_together([(scene, triangles(scene))], target, _checked_format(chosen), options)


def save_together(
    scenes: Iterable[Scene],
    path: str | os.PathLike[str],
    file_format: Format,
    options: SaveOptions | None = None,
    on_file: Callable[[Path], None] = _ignore,
    numbers: Sequence[int] | None = None,
) -> Path:
    """Write the models of several scenes into one file, with one scene in memory at a time.

    Args:
        scenes: iterated twice; at least one model in all. The division of models into scenes has no effect.
        path: path of the file, see `save`.
        file_format: one of `FORMATS`.
        options: the options.
        on_file: called with the path of every written file: libraries and images too.
        numbers: numbers of the models in the names of their nodes; by default they are counted from 0.

    Returns:
        The path of the file, which exists only when it is complete.

    Raises:
        As `save`.
    """
    chosen = _checked_format(file_format)
    options = options or SaveOptions()
    return _save_together(_Triangulated(scenes, options.pivot), Path(path), chosen, options, on_file, numbers)


def save_each(
    scene: Scene,
    folder: str | os.PathLike[str],
    file_format: Format = "glb",
    options: SaveOptions | None = None,
    name: Callable[[int], str] = "model_{:05d}".format,
    first_model: int = 0,
    on_saved: Callable[[int], None] | None = None,
    on_file: Callable[[Path], None] = _ignore,
) -> tuple[Path, ...]:
    """Write each model of a scene into its own file, which depends only on the model.

    Args:
        scene: any number of models.
        folder: made if it does not exist.
        file_format: one of `FORMATS`.
        options: the options.
        name: function from the number of a model to the file name without suffix.
        first_model: number of the first model.
        on_saved: called with the number of each model after its file is complete.
        on_file: called with the path of every written file: libraries and images too.

    Returns:
        The files in order. When interrupted, all files that exist are complete.

    Raises:
        As `save`.
    """
    options = options or SaveOptions()
    chosen = _checked_format(file_format)
    scene = at_pivot(scene, options.pivot)
    batch = triangles(scene)
    require_proper(scene)
    paths = []
    for index in range(scene.num_models):
        target = Path(folder) / f"{name(first_model + index)}.{chosen}"
        layout = _layout_of_one(scene.origins[index], chosen, options)
        with whole_file(target) as output:
            writer = _writer(output, target, chosen, layout, options)
            writer.add(scene_of_model(scene, index), batch.model(index), target.stem, layout.offsets[0])
            further_files = writer.finish()
        for file in (target, *further_files):
            on_file(file)
        paths.append(target)
        if on_saved is not None:
            on_saved(first_model + index)
    return tuple(paths)


@dataclass(frozen=True, slots=True)
class _Triangulated:
    """Scenes with their triangles, one after the other."""

    scenes: Iterable[Scene]
    pivot: Pivot

    def __iter__(self) -> Iterator[tuple[Scene, TriangleBatch]]:
        for each in self.scenes:
            scene = at_pivot(each, self.pivot)
            yield scene, triangles(scene)


def _save_together(
    scenes: Iterable[tuple[Scene, TriangleBatch]],
    target: Path,
    file_format: str,
    options: SaveOptions,
    on_file: Callable[[Path], None] = _ignore,
    numbers: Sequence[int] | None = None,
) -> Path:
    layout = _layout(scenes, options)
    num_models = len(layout.offsets)
    with whole_file(target) as output:
        writer = _writer(output, target, file_format, layout, options)
        count = 0
        for scene, batch in scenes:
            require_proper(scene)
            for index in range(scene.num_models):
                number = count if numbers is None else numbers[count]
                name = target.stem if num_models == 1 else f"model_{number}"
                writer.add(scene_of_model(scene, index), batch.model(index), name, layout.offsets[count])
                count += 1
        further_files = writer.finish()
    for file in (target, *further_files):
        on_file(file)
    return target


def _layout(scenes: Iterable[tuple[Scene, TriangleBatch]], options: SaveOptions) -> SceneLayout:
    bounds = [(*model_bounds(batch), batch.origins) for _, batch in scenes]
    low, high, origins = (np.concatenate(column) for column in zip(*bounds, strict=True))
    if options.in_place:
        return in_place(low, high, origins) if options.origin is None else around(np.array(options.origin), origins)
    return grid(low, high, origins, options.columns)


def counts_from_model(options: SaveOptions, file_format: str) -> bool:
    """Whether a file of one model counts from the origin of the model instead of `SaveOptions.origin`."""
    return options.pivot in ("footprint", "centre") or (file_format in HAVE_NODES and options.pivot != "local")


def _layout_of_one(origin: NDArray[np.float64], file_format: str, options: SaveOptions) -> SceneLayout:
    """Layout of a file of one model with an origin [3] in the world."""
    if options.origin is None or counts_from_model(options, file_format):
        return SceneLayout(origin, np.zeros((1, 3)))
    return around(np.array(options.origin), origin[None])


def _checked_format(file_format: str) -> str:
    if file_format not in FORMATS:
        raise UsageError(f"unknown file format {file_format!r}; choose one of {', '.join(FORMATS)}")
    return file_format


def _writer(
    output: Output, target: Path, file_format: str, layout: SceneLayout, options: SaveOptions
) -> AbstractWriter:
    in_world = options.pivot == "world" or (options.pivot != "local" and options.in_place)
    # A run has one format: the writers of the others are not imported.
    if file_format == "ply":
        from grammarlab.export.ply import PlyWriter  # noqa: PLC0415

        return PlyWriter(output, layout.origin, wide=layout.is_wide)
    if file_format == "stl":
        from grammarlab.export.stl import StlWriter  # noqa: PLC0415

        return StlWriter(output, layout.origin)
    if file_format == "3mf":
        from grammarlab.export.threemf import ThreeMfWriter  # noqa: PLC0415

        return ThreeMfWriter(output, layout.origin)
    if file_format in ("usd", "usdz"):
        require("pxr")
        from grammarlab.export.usd import UsdWriter  # noqa: PLC0415

        return UsdWriter(output, target, layout.origin, options.assets, in_world=in_world, packed=file_format == "usdz")
    if file_format == "obj":
        from grammarlab.export.obj import ObjWriter  # noqa: PLC0415

        return ObjWriter(output, target, layout.origin, options.assets)
    from grammarlab.export.glb import GlbWriter, MergedContent  # noqa: PLC0415
    from grammarlab.export.gltf_document import GltfDocument  # noqa: PLC0415
    from grammarlab.export.gltf_materials import GltfMaterials  # noqa: PLC0415

    document = GltfDocument(output)
    materials = GltfMaterials(document, options.assets)
    if options.reuse == "merged":
        return GlbWriter(document, MergedContent(document, materials), layout.origin, in_world=in_world)
    from grammarlab.export.glb import ReusedContent  # noqa: PLC0415

    instancing = options.reuse == "instancing"
    content = ReusedContent(document, materials, instancing=instancing)
    return GlbWriter(document, content, layout.origin, in_world=in_world)
