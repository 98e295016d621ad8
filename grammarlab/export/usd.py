"""USD files (OpenUSD, binary): models as components whose shapes are instances, y up, metres."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping
from importlib import import_module
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias, cast, final
from zipfile import ZipFile, ZipInfo

import numpy as np
from numpy.typing import NDArray

from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.srgb import linear_from_srgb
from grammarlab.assets.texture_files import find_texture
from grammarlab.derivation.materials import Materials
from grammarlab.export.instance_placements import Placements, placements_of
from grammarlab.export.model_files import AbstractWriter, Output, write_whole
from grammarlab.export.names import MaterialNumbers, ShapeNames, model_values, shape_names
from grammarlab.scene import Scene, TriangleBatch
from grammarlab.scene.instances import chosen
from grammarlab.scene.shading import ShadedMeshes, shaded_meshes
from grammarlab.scene.triangles import CREASE_ANGLE, texture_coordinates

_PACKAGES = ("Gf", "Kind", "Sdf", "Tf", "Usd", "UsdGeom", "UsdShade", "Vt")
Gf, Kind, Sdf, Tf, Usd, UsdGeom, UsdShade, Vt = (cast("Any", import_module(f"pxr.{name}")) for name in _PACKAGES)
"""The packages of OpenUSD, whose names are made at run time, so that no checker knows them."""
PrimPath: TypeAlias = Any
"""Place of a prim in a stage, an `Sdf.Path`."""

_WORLD = Sdf.Path("/World")
_MATERIALS = Sdf.Path("/World/Materials")
_PROTOTYPES = Sdf.Path("/Prototypes")
_PARTS = Sdf.ValueTypeNames
_PROPERTIES: Mapping[tuple[type, bool], Any] = {
    (bool, False): _PARTS.Bool,
    (int, False): _PARTS.Int,
    (int, True): _PARTS.IntArray,
    (float, False): _PARTS.Double,
    (float, True): _PARTS.DoubleArray,
    (str, False): _PARTS.String,
}
"""Kinds of attributes, of those that Blender reads, by the type of their value and whether it is a list."""


_ALIGNMENT = 64
"""In a USDZ, the data of each file begins at a multiple of this number of bytes, so that readers can map it."""
_HEADER_BYTES, _FIELD_BYTES = 30, 4
"""Sizes in a ZIP: of the header of a file without its name, and of that of a further field."""
_PADDING = 0x1986
"""Number of the field that has no other use, as OpenUSD writes it."""


@final
class UsdWriter(AbstractWriter):
    """A stage with one assembly, a component for each model, a group for each of its symbols, and instances in it.

    Textured shapes, whose texture coordinates depend on their places, are one mesh for each material.

    Args:
        output: the file.
        path: path of the file; images go beside it.
        origin: [3] origin of the file in the world, in metres; USD stores it in 64 bits.
        assets: folder of the textures; None leaves them out.
        in_world: whether the assembly is at its place in the world; otherwise a property of it names this place.
        packed: whether the file is an archive (USDZ) of the stage and its images.
    """

    def __init__(
        self,
        output: Output,
        path: Path,
        origin: NDArray[np.float64],
        assets: AssetRoot | None,
        *,
        in_world: bool = True,
        packed: bool = False,
    ) -> None:
        self._stream = output.stream
        self._packed = packed
        self._path = path
        self._assets = assets
        self._stage = Usd.Stage.CreateInMemory()
        UsdGeom.SetStageUpAxis(self._stage, UsdGeom.Tokens.y)
        UsdGeom.SetStageMetersPerUnit(self._stage, 1.0)
        world = UsdGeom.Xform.Define(self._stage, _WORLD)
        Usd.ModelAPI(world.GetPrim()).SetKind(Kind.Tokens.assembly)
        self._stage.SetDefaultPrim(world.GetPrim())
        if origin.any() and in_world:
            world.AddTranslateOp().Set(Gf.Vec3d(*origin.tolist()))
        elif origin.any():
            _set_properties(world.GetPrim(), {"origin": origin.tolist()})
        UsdGeom.Scope.Define(self._stage, _MATERIALS)
        self._stage.CreateClassPrim(_PROTOTYPES)
        self._numbers = MaterialNumbers()
        self._materials: dict[int, tuple[PrimPath, bool]] = {}
        self._images: dict[str, tuple[str, bytes]] = {}
        self._meshes: dict[tuple[bytes, int, str], PrimPath] = {}

    def add(self, scene: Scene, batch: TriangleBatch, name: str, offset: NDArray[np.float64]) -> None:
        """See `AbstractWriter.add`."""
        path = self._unused(_WORLD, name)
        model = UsdGeom.Xform.Define(self._stage, path)
        Usd.ModelAPI(model.GetPrim()).SetKind(Kind.Tokens.component)
        if offset.any():
            model.AddTranslateOp().Set(Gf.Vec3d(*offset.tolist()))
        for kind, values in model_values(scene).items():
            _set_properties(model.GetPrim(), values, f"{kind}:")
        names = shape_names(scene)
        textured = np.zeros(len(scene.materials), dtype=bool)
        for material in np.unique(batch.group_material).tolist():
            textured[material] = self._material(scene.materials, material)[1] and scene.surface is None
        self._add_textured(path, batch, names, textured)
        self._add_instances(path, chosen(scene, ~textured[scene.material]), names)

    def finish(self) -> tuple[Path, ...]:
        """See `AbstractWriter.finish`."""
        # The library writes files by name only.
        with TemporaryDirectory() as folder:
            whole = Path(folder, "stage.usdc")
            self._stage.GetRootLayer().Export(str(whole))
            if self._packed:
                self._stream.write(_package([(whole.name, whole.read_bytes()), *self._images.values()]))
                return ()
            self._stream.write(whole.read_bytes())
        files = {self._path.with_name(name): content for name, content in self._images.values()}
        for path, content in files.items():
            write_whole(path, content)
        return tuple(files)

    def _add_textured(
        self, model: PrimPath, batch: TriangleBatch, names: ShapeNames | None, textured: NDArray[np.bool_]
    ) -> None:
        for group in np.flatnonzero(textured[batch.group_material]).tolist():
            material = int(batch.group_material[group])
            vertices = slice(*batch.group_vertices[group : group + 2])
            triangles = slice(*batch.group_triangles[group : group + 2])
            rows = batch.triangles[triangles].astype(np.int64) - vertices.start
            name, extras = _label(names, batch.group_symbol, group, batch.materials, material)
            path = self._unused(model, name)
            mesh = self._mesh(path, batch.vertices[vertices], batch.normals[vertices], rows, material, batch.materials)
            coordinates = texture_coordinates(batch, triangles).reshape(-1, 2) * (1.0, -1.0) + (0.0, 1.0)
            _set_coordinates(mesh, coordinates, UsdGeom.Tokens.faceVarying)
            _set_properties(mesh.GetPrim(), extras)

    def _add_instances(self, model: PrimPath, scene: Scene, names: ShapeNames | None) -> None:
        if not len(scene):
            return
        used, mesh = np.unique(scene.mesh, return_inverse=True)
        shaded = shaded_meshes(scene, used, CREASE_ANGLE)
        placements = placements_of(scene, shaded, mesh)
        symbol = np.zeros(len(scene), np.int32) if scene.labels is None else scene.labels.symbol
        rows = np.flatnonzero(np.diff(shaded.mesh_triangles)[mesh] > 0)
        order = rows[np.lexsort((mesh[rows], scene.material[rows], symbol[rows]))]
        keys = np.stack([symbol[order], scene.material[order], mesh[order]], axis=1)
        groups: dict[tuple[int, int], PrimPath] = {}
        counts: dict[PrimPath, int] = {}
        prototypes: dict[tuple[int, ...], PrimPath] = {}
        layer = self._stage.GetRootLayer()
        for row, (kind, material, index) in zip(order.tolist(), keys.tolist(), strict=True):
            group = groups.get((kind, material))
            if group is None:
                name, extras = _label(names, symbol, row, scene.materials, material)
                group = groups[kind, material] = self._unused(model, name)
                xform = UsdGeom.Xform.Define(self._stage, group)
                Usd.ModelAPI(xform.GetPrim()).SetKind(Kind.Tokens.subcomponent)
                _set_properties(xform.GetPrim(), extras)
            if (kind, material, index) not in prototypes:
                prototypes[kind, material, index] = self._prototype(
                    shaded, index, scene.materials, material, group.name
                )
            number = counts[group] = counts.get(group, -1) + 1
            instance = group.AppendChild(f"{group.name}_{number}")
            _add_instance(layer, instance, prototypes[kind, material, index], placements, row)

    def _prototype(self, shaded: ShadedMeshes, index: int, table: Materials, material: int, name: str) -> PrimPath:
        """A hidden prim with one mesh, which instances refer to."""
        vertices = slice(*shaded.mesh_vertices[index : index + 2])
        rows = shaded.triangles[slice(*shaded.mesh_triangles[index : index + 2])]
        points, normals = shaded.points[vertices].astype(np.float32), shaded.normals[vertices].astype(np.float32)
        key = (points.tobytes() + normals.tobytes() + rows.tobytes(), self._numbers.number(table, material), name)
        if key not in self._meshes:
            path = self._meshes[key] = self._unused(_PROTOTYPES, name)
            UsdGeom.Xform.Define(self._stage, path)
            mesh = self._mesh(path.AppendChild(name), points, normals, rows, material, table)
            if shaded.coordinates is not None and self._material(table, material)[1]:
                _set_coordinates(mesh, shaded.coordinates[vertices], UsdGeom.Tokens.vertex)
        return self._meshes[key]

    def _mesh(
        self,
        path: PrimPath,
        points: NDArray[np.float32],
        normals: NDArray[np.float32],
        triangles: NDArray[np.integer],
        material: int,
        table: Materials,
    ) -> Any:
        mesh = UsdGeom.Mesh.Define(self._stage, path)
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points, np.float32)))
        mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(normals, np.float32)))
        mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(triangles), 3, np.int32)))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(triangles.astype(np.int32).ravel()))
        mesh.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(np.stack([points.min(axis=0), points.max(axis=0)])))
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        mesh.CreateDoubleSidedAttr(True)
        mesh.CreateDisplayColorAttr([Gf.Vec3f(*linear_from_srgb(table.color[material]).tolist())])
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(
            UsdShade.Material(self._stage.GetPrimAtPath(self._material(table, material)[0]))
        )
        return mesh

    def _material(self, table: Materials, material: int) -> tuple[PrimPath, bool]:
        """Path of a material, and whether it has a texture."""
        number = self._numbers.number(table, material)
        if number in self._materials:
            return self._materials[number]
        path = self._unused(_MATERIALS, self._numbers.name(table, material))
        shown = UsdShade.Material.Define(self._stage, path)
        surface = UsdShade.Shader.Define(self._stage, path.AppendChild("Surface"))
        surface.CreateIdAttr("UsdPreviewSurface")
        base, emissive = linear_from_srgb(np.stack((table.color[material], table.emissive[material]))).tolist()
        surface.CreateInput("diffuseColor", _PARTS.Color3f).Set(Gf.Vec3f(*base))
        surface.CreateInput("emissiveColor", _PARTS.Color3f).Set(Gf.Vec3f(*emissive))
        for name, value in (
            ("opacity", table.opacity[material]),
            ("metallic", table.metallic[material]),
            ("roughness", table.roughness[material]),
        ):
            surface.CreateInput(name, _PARTS.Float).Set(min(max(float(value), 0.0), 1.0))
        image = self._image(table, material, number)
        if image:
            self._add_texture(path, surface, image, cut_out=table.textures[material] in table.cut_out)
        shown.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
        self._materials[number] = path, bool(image)
        return self._materials[number]

    def _image(self, table: Materials, material: int, number: int) -> str:
        """Name of the file of the texture of a material beside the file; empty without one."""
        texture = find_texture(table.textures[material], self._assets, table.pictures)
        if texture is None:
            return ""
        if texture.name not in self._images:
            self._images[texture.name] = f"{self._path.stem}_texture_{number}{texture.suffix}", texture.content
        return self._images[texture.name][0]

    def _add_texture(self, path: PrimPath, surface: Any, image: str, *, cut_out: bool) -> None:
        reader = UsdShade.Shader.Define(self._stage, path.AppendChild("Coordinates"))
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", _PARTS.String).Set("st")
        picture = UsdShade.Shader.Define(self._stage, path.AppendChild("Texture"))
        picture.CreateIdAttr("UsdUVTexture")
        picture.CreateInput("file", _PARTS.Asset).Set(f"./{image}")
        picture.CreateInput("sourceColorSpace", _PARTS.Token).Set("sRGB")
        for name in ("wrapS", "wrapT"):
            picture.CreateInput(name, _PARTS.Token).Set("repeat")
        scale = surface.GetInput("diffuseColor").Get()
        picture.CreateInput("scale", _PARTS.Float4).Set(Gf.Vec4f(*scale, 1.0))
        picture.CreateInput("st", _PARTS.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
        surface.GetInput("diffuseColor").ConnectToSource(picture.ConnectableAPI(), "rgb")
        if cut_out:
            surface.GetInput("opacity").ConnectToSource(picture.ConnectableAPI(), "a")
            surface.CreateInput("opacityThreshold", _PARTS.Float).Set(0.5)

    def _unused(self, parent: PrimPath, name: str) -> PrimPath:
        """Path of a new child, called as closely as USD's rules for names allow."""
        word = Tf.MakeValidIdentifier(name)
        path, number = parent.AppendChild(word), 1
        while self._stage.GetPrimAtPath(path):
            number += 1
            path = parent.AppendChild(f"{word}_{number}")
        return path


def _package(files: Iterable[tuple[str, bytes]]) -> bytes:
    """USDZ of files, the stage first. The library itself puts the time of day into it."""
    package = BytesIO()
    with ZipFile(package, "w") as archive:
        for name, content in files:
            entry = ZipInfo(name)
            start = package.tell() + _HEADER_BYTES + len(name.encode()) + _FIELD_BYTES
            padding = -start % _ALIGNMENT
            entry.extra = struct.pack("<HH", _PADDING, padding) + bytes(padding)
            archive.writestr(entry, content)
    return package.getvalue()


def _label(
    names: ShapeNames | None, symbols: NDArray[np.int32] | None, row: int, table: Materials, material: int
) -> tuple[str, dict[str, Any]]:
    """Name and properties of shapes; of those without labels, only a name."""
    if names is None or symbols is None:
        return "Shape", {}
    symbol = int(symbols[row])
    return names.name(symbol, table, material), names.extras(symbol, material)


def _set_properties(prim: Any, values: Mapping[str, Any], prefix: str = "") -> None:
    """Set attributes that programs show as properties of the user: numbers, truth values, texts and lists of numbers.

    Attributes instead of custom data, which Blender and Houdini leave out.
    """
    for name, value in values.items():
        kind = _PROPERTIES[type(value[0]), True] if isinstance(value, list) else _PROPERTIES[type(value), False]
        attribute = prim.CreateAttribute(_unused_property(prim, f"userProperties:{prefix}{name}"), kind)
        attribute.Set(value)
        attribute.SetDisplayName(name)


def _unused_property(prim: Any, name: str) -> str:
    """Name of a new attribute, as close as USD's rules allow: different names may have one valid form."""
    valid = ":".join(Tf.MakeValidIdentifier(word) for word in name.split(":"))
    unused, number = valid, 1
    while prim.HasAttribute(unused):
        number += 1
        unused = f"{valid}_{number}"
    return unused


def _set_coordinates(mesh: Any, coordinates: NDArray[np.floating], interpolation: str) -> None:
    """Set texture coordinates [N, 2], v upwards."""
    primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", _PARTS.TexCoord2fArray, interpolation)
    primvar.Set(Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(coordinates, np.float32)))


def _add_instance(layer: Any, path: PrimPath, prototype: PrimPath, placements: Placements, row: int) -> None:
    """Add an instance; specs are written directly, since models have hundreds."""
    prim = Sdf.CreatePrimInLayer(layer, path)
    prim.specifier = Sdf.SpecifierDef
    prim.typeName = "Xform"
    prim.referenceList.Prepend(Sdf.Reference("", prototype))
    prim.instanceable = True
    x, y, z, w = placements.rotation[row].tolist()
    operations: Iterable[tuple[str, Any, Any]] = (
        ("xformOp:translate", _PARTS.Double3, Gf.Vec3d(*placements.translation[row].tolist())),
        ("xformOp:orient", _PARTS.Quatf, Gf.Quatf(w, x, y, z)),
        ("xformOp:scale", _PARTS.Float3, Gf.Vec3f(*placements.scale[row].tolist())),
    )
    for name, kind, value in operations:
        Sdf.AttributeSpec(prim, name, kind).default = value
    order = Sdf.AttributeSpec(prim, "xformOpOrder", _PARTS.TokenArray, Sdf.VariabilityUniform)
    order.default = Vt.TokenArray([name for name, _, _ in operations])
