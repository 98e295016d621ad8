"""Every operation, function and attribute that the language page promises: the checker knows it, and it derives."""

from __future__ import annotations

import pytest

from grammarlab.derivation import derive
from grammarlab.derivation.functions import BUILTINS, SHAPE_ATTRIBUTES
from grammarlab.errors import DerivationError
from grammarlab.language.checking.check import check_text
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax import builtins
from grammarlab.runs.sample.checks import SUPPORTED

SEQUENCES = [
    *(
        "extrude(3)",
        "extrude('0.5)",
        "extrude(world.up, 3)",
        "extrude(world.up.flatTop, 3)",
        "extrude(vertex.normal, 1)",
    ),
    *("extrude(face.normal, 2)", "extrude(-2)", "taper(3)", "taper(-3)", "offset(-1)", "offset('-0.1)"),
    *("offset(-1, inside)", "offset(1, border)", "innerRect()", "t(1, '0.5, 0)", "s('1, 2, '0.5)", "scale('1, 2, 3)"),
    *("r(10, 20, 30)", "r(scopeCenter, 0, 90, 0)", "center(xz)", "translate(rel, world, 0, 1, 0)"),
    *("translate(abs, object, 0, 1, 0)", "rotate(rel, object, 0, 30, 0)", "rotate(abs, world, 0, 30, 0)"),
    *('i("builtin:cube")', 'i("builtin:cylinder", zUp)', 'i("builtin:cone", yUp, keepSizeAlignPosition)'),
    *("primitiveCube()", "primitiveCube(1, 2, 3)", "primitiveQuad()", "primitiveQuad(2, 3)", "primitiveDisk(8, 3)"),
    *("primitiveSphere(8, 6, 3)", "primitiveCylinder(8, 2, 3)", "primitiveCone(8)", "primitiveDisk()"),
    *('color("#ff8800")', 'color("#ff880080")', "color(1, 0.5, 0)", "color(2, -1, 0.5, 0.5)", 'texture("wall.png")'),
    *(
        "set(material.color.r, 0.5)",
        "set(material.opacity, 0.5)",
        'set(material.color.rgb, "#102030")',
        "set(height, 7)",
    ),
    *('set(sel("material." + "opacity"), 0.5)', "set(material.roughness, 0.2)", "set(material.metallic, 1)"),
    *("roofHip(30)", "roofHip(byHeight, 3, 1, true)", "roofGable(30, 1, 1, false, 1)", "roofGable(byAngle, 30, 1)"),
    *(
        "roofPyramid(byHeight, 3)",
        "roofShed(20, 1)",
        "roofShed(byHeight, 3)",
        "roofRidge(30)",
        "roofRidge(byHeight, 3)",
    ),
    *("mirror(true, false, false)", "reverseNormals()", "alignScopeToAxes(y)", "alignScopeToAxes(world.xyz)"),
    *("alignScopeToAxes(object.y)", "alignScopeToAxes()", "alignScopeToGeometry(yUp, largest, longest)"),
    *("alignScopeToGeometry(zUp, 0, 1)", "alignScopeToGeometry(yUp, any, world.lowest)", "rotateScope(0, 30, 0)"),
    *("setPivot(yzx, 3)", 'report("a.b", 3)', 'report("c", true)', "print(height)", 'label("wall")'),
    *(
        "split(x) { 2 : A | ~1 : B | '0.1 : C }",
        "split(z, noAdjust) { { ~2 : A | 1 : B }* | 3 : C }",
        "split(x) { 2 : A }*",
    ),
    *("split(x) { { ~2 : A | { ~1 : B }* | 1 : C }* }", "split(x) { 1 : A | { 2 : B | { 1 : C | 2 : A } } }*"),
    *("comp(f) { top : A | side = B }", "comp(e) { all : A }", "comp(v) { all : A }", "comp(fe) { front : A }"),
    *("comp(fv) { all : A }", "comp(f, noAlign) { all : A }", "comp(f) { 0 : A | world.up : B | object.top =: C }"),
    *("comp(f) { top || geometry.area() > 3 : A }", "comp(e) { border : split(x) { 1 : A }* | inside : B }"),
    *(
        "roofHip(30) comp(e) { hip : A | valley : B | ridge : C | eave : A }",
        "setback(1) { front : A | remainder : B }",
        "setback(1) { streetSide : A | noStreetSide = B | remainder : B }",
    ),
    *("setback('0.1) { left || right = A | remainder : B }", "shapeL(1, 2) { shape : A | remainder : B }"),
    *("shapeU(1, 2, 1) { shape : A }", "shapeO(1, 1, 1, 1) { shape : A | remainder = B }"),
    *("innerRectangle(edge) { shape : A | remainder : B }", "innerRectangle(scope) { shape = A }"),
    "set(scope.tx, 1) set(scope.ry, 3) set(scope.sz, 2) set(pivot.pz, 1) set(pivot.oy, 9) A",
    *("scatter(surface, 3, uniform) { A }", "scatter(scope, 3, gaussian, left, '0.1) { primitiveCube() }"),
    *(
        "s(-1, 2, -3)",
        "primitiveCube(-1, 2, 3)",
        "setback([1, 2]) { all : A }",
        "setback(comp(fe) { all : 1 }) { all : A }",
    ),
    *("split(u, unitSpace, 0) { 1 : A | { ~1 : B }* }", "split(v, uvSpace, 1) { '0.5 : A }", "projectUV(3) A"),
    *("setupProjection(0, scope.xy, ~2, '1, 0, 0, 1) projectUV(0) copyUV(0, 1) deleteUV(0) A",),
    *("tileUV(0, ~2, 0) normalizeUV(0, uvUniform, collectiveAllFaces) A", "rotateUV(0, 9) scaleUV(0, 1, 2) A"),
    *(
        "translateUV(0, 1, 2) A",
        "[ t(0, 1, 0) A ] B.",
        "NIL",
        "Wall(3) Wall(1, 2)",
        "case p(0.5) : A else : 30% : B 30% : C else : NIL",
    ),
]
VALUES = [
    *("rand()", "rand(2)", "rand(1, 2)", "p(0.3)", 'fileRandom("*.png")', 'listRandom("a;b;")', "scope.tx + scope.ry"),
    *("scope.tx + pivot.px * pivot.oy", "print(scope.sx) + 1", 'fileSearch("*" + scope.sx) + fileExists("a")'),
    *("scope.sx * scope.elevation", "split.index / split.total", "comp.index + comp.total", "comp.sel"),
    *("geometry.area + geometry.area(top)", "geometry.volume", "geometry.isRectangular(1)", "geometry.angle(maxSlope)"),
    *("geometry.height()", "geometry.nVertices + geometry.nFaces + geometry.nEdges + geometry.nHoles"),
    *("geometry.isConcave()", "geometry.isPlanar(1)", "geometry.isOriented(world.up)", "material.color.r"),
    *("initialShape.origin.px", "initialShape.name", "abs(-1) + ceil(1) + floor(1) + rint(1) + sqrt(2) + pow(2, 3)"),
    *("sin(1) + cos(1) + tan(1) + asin(1) + acos(1) + atan(1) + atan2(1, 2)", "exp(1) + ln(2) + log10(3) + 5 % 3"),
    *("isnan(1) || isinf(1) || !(1 < 2)", 'str(1) + len("a") + "b"', 'float("1") + find("a", "b", 0)', 'bool("f")'),
]
VALUES += ['assetBestSize("*.obj", "xz") + assetApproxRatio("*", "xy", 2)', 'assetFitSize("*.obj", "x", 0.2)']
VALUES += ['assetsSortSize("", xz, 0) + assetsSortRatio("", xyz)', 'imagesSortRatio("", yx) + imageInfo("a.png", sy)']
VALUES += ['imageBestRatio("*.png", "xz") + imageApproxRatio("*.png", "yz", 3)']
VALUES += ["[1, 2; 3, 4][1, 0] + size([1:3]) + nRows(floatArray)", "comp(f) { top : comp.index | side = 2 }"]
VALUES += ["geometry.du(0, uvSpace) + geometry.dv(2, unitSpace)", "geometry.uMin + geometry.uMax(1)"]
VALUES += ["geometry.vMin(2) + geometry.vMax", "geometry.hasUVs(0) || geometry.hasUVs"]
VALUES += ["initialShape.origin.oy", "initialShape.symbol", "trim.vertical", "convert(x, scope, world, pos, 1, 2, 3)"]
HEAD = "attr height = 3\nWall(x) --> extrude(x) A\nWall(x, y) --> extrude(x + y) B\n"


@pytest.mark.parametrize("sequence", [*SEQUENCES, *(f"print({value})" for value in VALUES)])
def test_a_feature_is_carried_out_and_found_in_order(sequence):
    text = f"{HEAD}@StartRule\nLot --> {sequence}"
    assert [finding for finding in check_text(text, "lot.cga", SUPPORTED) if finding.severity != "warning"] == []
    assert derive(Grammar.parse(text), 3, 1, footprint=(12.0, 8.0)).num_models == 3


@pytest.mark.parametrize(
    "sequence",
    ["comp(g) { all : A }", 'print(assetMetadata("a.obj", "b", 1))'],
)
def test_what_is_not_carried_out_is_reported_and_refused_where_a_shape_comes_to_it(sequence):
    text = f"Lot --> {sequence}"
    assert "unsupported" in {finding.severity for finding in check_text(text, "lot.cga", SUPPORTED)}
    with pytest.raises(DerivationError, match=r"<text>:1:\d+: .*(not supported|unknown name)"):
        derive(Grammar.parse(text), 1, 1)
    assert derive(Grammar.parse(f"Lot --> case 1 > 2 : {sequence} else : A"), 1, 1).num_models == 1


def test_whatever_derivations_know_is_in_the_tables_of_the_language():
    assert BUILTINS.keys() <= builtins.functions().keys()
    assert SHAPE_ATTRIBUTES.keys() <= builtins.attributes().keys()
    named = builtins.operations().keys() | builtins.blocks().keys() | {"NIL", "inline"}
    assert (SUPPORTED.operations or frozenset()) <= named
