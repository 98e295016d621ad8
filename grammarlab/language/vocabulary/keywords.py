"""Keywords of CGA: axes, sides, modes, kinds of components."""

from __future__ import annotations

from collections.abc import Mapping

_AXES = "x y z"
_SIDES = "front back left right top bottom"
_COMPASS = "world.south world.north world.west world.east world.up world.down world.side"
_OBJECT_SIDES = "object.front object.back object.left object.right object.top object.bottom object.side"
_STREET_SIDES = "street.front street.back street.left street.right street.side"
_SLOPES = "vertical horizontal aslant nutant side"
_COMPONENT_SELECTORS = (
    f"{_SIDES} {_OBJECT_SIDES} {_COMPASS} {_STREET_SIDES} {_SLOPES} all border inside eave hip valley ridge "
    "streetSide noStreetSide"
)

KEYWORDS: Mapping[str, frozenset[str]] = {
    name: frozenset(words.split())
    for name, words in {
        "axis": _AXES,
        "uv_axis": "u v",
        "adjust": "adjust noAdjust",
        "uv_space": "uvSpace unitSpace",
        "axes": "x y z xy xz yz xyz",
        "world_axes": "x y z world.x world.y world.z world.xyz object.x object.y object.z object.xyz",
        "axis_pair": "xy yx xz zx yz zy",
        "axis_order": "xyz yzx zxy",
        "up": "yUp zUp",
        "face": "world.lowest largest any auto",
        "edge": "world.lowest longest auto",
        "component": "f e fe v fv g m h",
        "component_scope": "zUp noAlign",
        "component_selector": _COMPONENT_SELECTORS,
        "setback_selector": f"{_SIDES} side {_OBJECT_SIDES} {_COMPASS} {_STREET_SIDES} streetSide noStreetSide all "
        "remainder uv.left uv.right uv.bottom uv.top uv.uMin uv.uMax uv.vMin uv.vMax",
        "shape_selector": "shape remainder",
        "remainder_selector": "remainder",
        "extrusion": "world.up world.up.flatTop face.normal vertex.normal x y z world.x world.y world.z",
        "envelope": "normal world.up",
        "keep_faces": "all inside border",
        "cleanup": "all edges faces vertices",
        "insert": "alignSizeAndPosition keepSizeAndPosition keepSizeAlignPosition",
        "insert_cleanup": "numericalCleanup noCleanup",
        "height_direction": "scope.y vertex.normal",
        "height_alignment": "alignPosition keepPosition",
        "rectangle": "scope edge",
        "uv_mode": "uv uvUniform u v",
        "uv_faces": "separatePerFace collectiveAllFaces",
        "projection": "scope.xy scope.xz scope.yx scope.yz scope.zx scope.zy "
        "world.xy world.xz world.yx world.yz world.zx world.zy",
        "rotation_centre": "scopeOrigin scopeCenter",
        "mode": "abs rel",
        "system": "scope pivot object world",
        "material_target": "shape geometry all",
        "normals": "hard conform soft auto",
        "roof": "byAngle byHeight",
        "domain": "surface volume scope",
        "uniform": "uniform",
        "gaussian": "gaussian",
        "scatter_mean": f"center {_SIDES}",
        "tagged": "auto all faces edges vertices",
        "tag_components": "e v",
        "merge": "append unify recompose",
        "slope_angle": "maxSlope zenith azimuth",
        "orientation": f"all surface side {_SIDES} {_OBJECT_SIDES} {_COMPASS} {_STREET_SIDES}",
        "target": "intra inter all",
        "comparison": "world.northernmost world.southernmost world.easternmost world.westernmost world.highest "
        "world.lowest area.largest area.smallest",
        "asset_measure": "sx sy sz tx ty tz",
        "asset_name": "g m",
        "image_measure": "sx sy",
        "coordinate": "X Y lat lon",
        "position_type": "pos orient",
        "material_source": "used shape geometry",
        "material_mode": "all changed",
    }.items()
}
