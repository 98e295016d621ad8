"""Operations, functions and shape attributes of CGA, with the types of their arguments and results.

The tables have the notation of CGA's reference: one line per form, a type or a set of keywords (``$axis``) for each
argument, ``?`` after an optional argument. For the features that grammarlab supports, see
`grammarlab.language.checking.check.SupportedFeatures`.

Argument types: ``float``, ``bool``, ``string``, arrays of them (``float[]``), alternatives (``float|string``),
``any``; ``size`` is a float that may be relative (``'0.5``), ``tile`` one that may be relative or floating (``~0.5``),
``place`` the name of an attribute.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from grammarlab.language.syntax.keywords import KEYWORDS

_OPERATIONS = """
i(string) i(string, $up) i(string, $up, $insert) i(string, $up, $insert, $insert_cleanup)
extrude(size) extrude($extrusion, size)
envelope($envelope, float, float, float)
envelope(float, float, float, float, float, float, float)
envelope($envelope, float, float, float, float, float)
envelope($envelope, float, float, float, float, float, float, float)
envelope($envelope, float, float, float, float, float, float, float, float, float)
envelope($envelope, float, float[], float[])
taper(size)
roofGable(float, float?, float?, bool?, float?) roofGable($roof, float, float?, float?, bool?, float?)
roofHip(float, float?, bool?) roofHip($roof, float, float?, bool?)
roofPyramid(float) roofPyramid($roof, float)
roofRidge(float) roofRidge($roof, float)
roofShed(float, float?) roofShed($roof, float, float?)
offset(size) offset(size, $keep_faces)
primitiveQuad() primitiveQuad(float, float)
primitiveDisk(float?, float?)
primitiveCube() primitiveCube(float, float, float)
primitiveSphere() primitiveSphere(float, float, float?)
primitiveCylinder(float?) primitiveCylinder(float, float, float)
primitiveCone(float?) primitiveCone(float, float, float)
insertAlongUV(float, string, float) insertAlongUV(float, string, float, $height_direction, $height_alignment)
footprint()
innerRect()
cleanupGeometry($cleanup, float)
convexify(float?)
deleteHoles()
reverseNormals()
setNormals($normals) softenNormals(float)
mirror(bool, bool, bool)
rectify(float)
reduceGeometry(float)
resetGeometry()
trim()
tag(string, $tagged?) deleteTags(string?, $tagged?) setTagsFromEdgeAttrs()
texture(string)
setupProjection(float, $projection, tile, tile, size?, size?, float?)
setupUV(float, tile, tile, size?, size?, float?)
projectUV(float)
translateUV(float, size, size) offsetUV(float, size, size) scaleUV(float, size, size)
rotateUV(float, float) tileUV(float, tile, tile)
normalizeUV(float, $uv_mode, $uv_faces)
deleteUV(float) copyUV(float, float)
t(size, size, size) translate($mode, $system, size, size, size)
s(size, size, size) scale(size, size, size)
r(float, float, float) r($rotation_centre, float, float, float) rotate($mode, $system, float, float, float)
center($axes)
alignScopeToAxes($world_axes?)
alignScopeToGeometry($up, float, float) alignScopeToGeometry($up, $face, float)
alignScopeToGeometry($up, float, $edge) alignScopeToGeometry($up, $face, $edge)
alignScopeToGeometry($up, float) alignScopeToGeometry($up, $face)
alignScopeToGeometryBBox($axis_pair)
rotateScope(float, float, float)
setPivot($axis_order, float)
mirrorScope(bool, bool, bool)
NIL()
label(string)
set(place, any)
color(string) color(float, float, float, float?)
resetMaterial($material_target?) setMaterial(string[])
report(string, float|bool|string)
print(any)
"""

_BLOCKS = """
split($axis, $adjust?) {size}
split($uv_axis, $uv_space, float) {size}
splitArea($axis, $adjust?) {size}
splitAndSetbackPerimeter(size) {size} splitAndSetbackPerimeter(size, float, bool[]) {size}
comp($component, $component_scope?) {component_selector}
modify($component, $component_scope?) {component_selector}
innerRectangle($rectangle) {shape_selector}
setback(size|float[], float?) {setback_selector}
setbackPerEdge(size, float?) {setback_selector}
setbackToArea(size, float?) {setback_selector} setbackToArea(size, float[], float?) {setback_selector}
setbackToArea(size, float[], float[], float?) {setback_selector}
shapeL(size, size) {shape_selector}
shapeU(size, size, size) {shape_selector}
shapeO(size, size, size, size) {shape_selector}
scatter($domain, float, $uniform) {} scatter($domain, float, $gaussian, $scatter_mean?, size?) {}
union() {} subtract() {} intersect() {}
"""

_FUNCTIONS = """
float|float[] abs(float|float[]) ceil(float|float[]) floor(float|float[]) rint(float|float[])
float acos(float) asin(float) atan(float) atan2(float, float) cos(float) sin(float) tan(float)
float exp(float) ln(float) log10(float) pow(float, float) sqrt(float)
bool|bool[] isinf(float|float[]) isnan(float|float[])
bool|bool[] isNull(any) isnull(any)
bool p(float)
float rand() rand(float) rand(float, float)
bool bool(any)
bool[] boolArray(any?)
float float(any)
float[] floatArray(any?)
string str(any)
string[] stringArray(any?)
any sel(string)
float count(string, string) find(string, string, float) len(string)
string[] splitString(string, string)
string substring(string, float, float)
float geometry.angle($slope_angle) geometry.area($orientation?) geometry.boundaryLength()
float geometry.du(float, $uv_space) geometry.dv(float, $uv_space)
string[] geometry.groups() geometry.materials() geometry.tags(string?, $tagged?)
bool geometry.hasTags(string?, $tagged?) geometry.hasUVs(float?)
float geometry.height() geometry.lowerheight()
bool geometry.isClosedSurface() geometry.isConcave() geometry.isInstanced() geometry.isOriented($orientation)
bool geometry.isPlanar(float) geometry.isRectangular(float)
float geometry.nEdges() geometry.nFaces() geometry.nHoles() geometry.nVertices() geometry.volume()
float geometry.uMin(float?) geometry.uMax(float?) geometry.vMin(float?) geometry.vMax(float?)
string[] getMaterial($material_source?, $material_mode?) readMaterial(string)
bool fileExists(string)
string fileSearch(string)
string[] filesSearch(string) readStringTable(string)
float[] readFloatTable(string)
string readTextFile(string)
float assetInfo(string, $asset_measure)
any assetMetadata(string, string, any)
string assetNamingInfo(string, $asset_name)
string[] assetNamingInfos(string, $asset_name)
string|string[] assetsSortRatio(string|string[], $axes) assetsSortSize(string|string[], $axes, float)
string|string[] imagesSortRatio(string|string[], $axis_pair)
float imageInfo(string, $image_measure)
bool inside($target?, string?) overlaps($target?, string?) touches($target?, string?)
float minimumDistance($target, string) contextCompare($target, string, $comparison) contextCount($target, string)
float findFirst(any, any, float?)
float nColumns(any) nRows(any) size(any)
any setElems(any, any, any) setElems(any, any, any, any)
float[] sortIndices(any) sortRowIndices(any)
float|string sum(any)
any transpose(any)
float edgeAttr.getFloat(string)
string edgeAttr.getString(string)
bool edgeAttr.getBool(string)
float convert($axis, $system, $system, $position_type, float, float, float)
float[] convert($system, $system, $position_type, float[])
float getGeoCoord($coordinate)
string getTreeKey()
any print(any)
bool isTagged(string, $tag_components?)
float findLast(string, string)
string getPrefix(string, string) getRange(string, string, string) getSuffix(string, string)
string replace(string, string, float|bool|string)
string listAdd(string, string) listClean(string) listFirst(string) listFromArray(any)
float listCount(string, string) listIndex(string, string) listSize(string)
string listItem(string, float) listLast(string) listRandom(string) listRange(string, float, float)
string listRemove(string, string) listRemoveAll(string, string) listRetainAll(string, string) listTerminate(string)
string[] listToArray(string)
string assetApproxRatio(string, string, float) assetApproxSize(string, string, float)
string assetBestRatio(string, string) assetBestSize(string, string) assetFitSize(string, string, float)
string fileBasename(string) fileDirectory(string) fileExtension(string) fileName(string) fileRandom(string)
string imageApproxRatio(string, float|string, float) imageBestRatio(string, float|string)
any clamp(any, any, any) max(any, any) min(any, any)
float colorHexToB(string) colorHexToG(string) colorHexToH(string) colorHexToO(string) colorHexToR(string)
float colorHexToS(string) colorHexToV(string)
string colorHSVToHex(float, float, float) colorHSVOToHex(float, float, float, float)
string colorRGBToHex(float, float, float) colorRGBOToHex(float, float, float, float)
string colorRamp(string, float)
"""

_ATTRIBUTES = """
string comp.sel
float comp.index comp.total split.index split.total seedian uid
string initialShape.name initialShape.startRule initialShape.symbol
float initialShape.origin.px initialShape.origin.py initialShape.origin.pz
float initialShape.origin.ox initialShape.origin.oy initialShape.origin.oz
float pivot.px pivot.py pivot.pz pivot.ox pivot.oy pivot.oz
float scope.tx scope.ty scope.tz scope.rx scope.ry scope.rz scope.sx scope.sy scope.sz scope.elevation
bool trim.horizontal trim.vertical
string material.name material.shader material.color.rgb
float material.color.r material.color.g material.color.b material.color.a
float material.ambient.r material.ambient.g material.ambient.b
float material.specular.r material.specular.g material.specular.b
float material.emissive.r material.emissive.g material.emissive.b
float material.opacity material.reflectivity material.shininess material.bumpValue material.metallic material.roughness
bool material.doubleSided
"""
_MAPS = "colormap bumpmap dirtmap specularmap opacitymap normalmap emissivemap occlusionmap roughnessmap metallicmap"

READ_ONLY_ATTRIBUTES = frozenset(
    {"comp.sel", "comp.index", "comp.total", "split.index", "split.total", "scope.elevation"}
    | {"uid", "initialShape.name", "initialShape.startRule", "initialShape.symbol"}
)
"""Shape attributes that ``set`` refuses."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """Types of an argument."""

    types: tuple[str, ...]
    """Names of types, or one ``$set`` of `KEYWORDS`."""
    optional: bool = False

    @property
    def keywords(self) -> frozenset[str]:
        """Allowed keywords; empty if a value is expected."""
        return KEYWORDS[self.types[0][1:]] if self.types[0].startswith("$") else frozenset()


@dataclass(frozen=True, slots=True)
class Signature:
    """One form of an operation or function."""

    name: str
    parameters: tuple[Parameter, ...]
    result: tuple[str, ...] = ()
    """Types of the result; empty for operations."""
    heads: str | None = None
    """Head of a part of its block: ``size`` or a set of `KEYWORDS`; None without such parts."""

    @property
    def fewest(self) -> int:
        """The smallest number of arguments."""
        return sum(not parameter.optional for parameter in self.parameters)

    def takes(self, num_arguments: int) -> bool:
        """Whether that many arguments fit."""
        return self.fewest <= num_arguments <= len(self.parameters)


Signatures = Mapping[str, tuple[Signature, ...]]
_FORM = re.compile(r"([\w.]+)\(([^()]*)\)(?: \{(\w*)\})?")


def _read(table: str, typed: bool) -> Signatures:
    forms: dict[str, tuple[Signature, ...]] = {}
    for line in table.strip().splitlines():
        result = tuple(line.split(" ", 1)[0].split("|")) if typed else ()
        for name, arguments, heads in _FORM.findall(line.split(" ", 1)[1] if typed else line):
            parameters = tuple(
                Parameter(tuple(argument.rstrip("?").split("|")), argument.endswith("?"))
                for argument in arguments.split(", ")
                if argument
            )
            forms[name] = (*forms.get(name, ()), Signature(name, parameters, result, heads or None))
    return forms


@cache
def operations() -> Signatures:
    """Forms of every operation without a block, by name."""
    return _read(_OPERATIONS, typed=False)


@cache
def blocks() -> Signatures:
    """Forms of every operation with a block, by name."""
    return _read(_BLOCKS, typed=False)


@cache
def functions() -> Signatures:
    """Forms of every function, by name."""
    return _read(_FUNCTIONS, typed=True)


@cache
def attributes() -> Mapping[str, str]:
    """Type of every shape attribute, by name."""
    types = {name: kind for kind, *names in map(str.split, _ATTRIBUTES.strip().splitlines()) for name in names}
    for texture in _MAPS.split():
        types[f"material.{texture}"] = "string"
        types |= {f"material.{texture}.{part}": "float" for part in ("su", "sv", "tu", "tv", "rw")}
    return types
