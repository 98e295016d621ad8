"""Checks of definitions: unique names, distinct parameters, well-formed annotations."""

from __future__ import annotations

from dataclasses import dataclass

from grammarlab.language.checking.percentages import constant
from grammarlab.language.checking.symbols import Remarks, suggestion
from grammarlab.language.syntax.syntax_tree import (
    Annotation,
    Attribute,
    Definition,
    Function,
    Import,
    Rule,
    RuleFile,
    Style,
)


@dataclass(frozen=True, slots=True)
class _Form:
    """Arguments of an annotation."""

    fewest: int = 0
    most: int = 0
    keywords: frozenset[str] = frozenset()
    of_attributes: bool = True
    """Whether it applies to attributes only."""


_ANY_NUMBER = 10_000
"""Number of values of an annotation that stands for any number."""
_RESTRICTED = frozenset({"restricted"})
_HANDLE = frozenset(
    {"shape", "axis", "type", "reference", "align", "color", "skin", "slip", "translate", "minColor", "extend"}
    | {"occlusion", "default"}
)
_ANYWHERE = _Form(of_attributes=False)
_ANNOTATIONS = {
    "Acceptance": _Form(1, _ANY_NUMBER, of_attributes=False),
    "Angle": _Form(),
    "Color": _Form(),
    "Description": _Form(1, 1, of_attributes=False),
    "Directory": _Form(),
    "DisplayName": _Form(1, 1, of_attributes=False),
    "Distance": _Form(),
    "Enum": _Form(0, _ANY_NUMBER, _RESTRICTED | {"valuesAttr"}),
    "File": _Form(0, _ANY_NUMBER),
    "Group": _Form(0, _ANY_NUMBER, of_attributes=False),
    "Handle": _Form(0, _ANY_NUMBER, _HANDLE),
    "Hidden": _Form(0, _ANY_NUMBER, of_attributes=False),
    "InLine": _ANYWHERE,
    "InMesh": _ANYWHERE,
    "InPoint": _ANYWHERE,
    "InPointCloud": _ANYWHERE,
    "InPolygon": _ANYWHERE,
    "MaterialFile": _Form(),
    "Order": _Form(1, 1, of_attributes=False),
    "Out": _Form(0, 0, frozenset({"granularity"}), of_attributes=False),
    "Percent": _Form(),
    "Range": _Form(0, _ANY_NUMBER, _RESTRICTED | {"min", "max", "stepsize"}),
    "RuleFileDescription": _Form(1, 1, of_attributes=False),
    "StartRule": _ANYWHERE,
}
_BY_LOWER = {name.lower(): name for name in _ANNOTATIONS}


def check_declarations(tree: RuleFile, remarks: Remarks) -> None:
    """Report duplicate definitions, and annotations without a meaning."""
    first_definitions: dict[tuple[str, str, int], Definition] = {}
    styles = {"Default"}
    for definition in tree.definitions:
        if isinstance(definition, Style):
            _check_style(definition, styles, remarks)
            first_definitions.clear()
            continue
        _check_duplicate(definition, first_definitions, remarks)
        for annotation in definition.annotations:
            _check_annotation(annotation, definition, remarks)
        if isinstance(definition, Rule | Function):
            _check_parameters(definition, remarks)


def _check_style(style: Style, styles: set[str], remarks: Remarks) -> None:
    if style.name in styles:
        remarks.error("duplicate-definition", style.location, f"the style {style.name} is defined twice")
    if style.base and style.base not in styles:
        message = f"unknown style '{style.base}'"
        remarks.error("unknown-name", style.location, message, suggestion(style.base, styles))
    styles.add(style.name)


def _check_duplicate(
    definition: Definition, first_definitions: dict[tuple[str, str, int], Definition], remarks: Remarks
) -> None:
    match definition:
        case Rule(name=name):
            key, subject = ("rule", name, len(definition.parameters)), f"the rule {name}"
        case Attribute(name=name):
            key, subject = ("value", name, 0), f"{'the constant' if definition.constant else 'the attribute'} {name}"
        case Function(name=name):
            key, subject = ("value", name, len(definition.parameters)), f"the function {name}"
        case Import(alias=alias):
            key, subject = ("import", alias, 0), f"the import {alias}"
        case Style():
            return
    first = first_definitions.setdefault(key, definition)
    if first is not definition:
        message = f"{subject} is defined twice, first in line {first.location.line}"
        hint = "rules and functions of one name must differ in the number of their parameters"
        remarks.error("duplicate-definition", definition.location, message, hint)


def _check_parameters(definition: Rule | Function, remarks: Remarks) -> None:
    names = (*definition.parameters, *(variable.name for variable in definition.variables))
    for name in sorted({name for name in names if names.count(name) > 1}):
        message = f"{definition.name} has two parameters called {name}"
        remarks.error("duplicate-parameter", definition.location, message)


def _check_annotation(annotation: Annotation, definition: Definition, remarks: Remarks) -> None:
    name = _BY_LOWER.get(annotation.name.lower())
    if name is None:
        hint = suggestion(annotation.name, _ANNOTATIONS)
        message = f"unknown annotation @{annotation.name}"
        remarks.warning("unknown-annotation", annotation.location, message, hint)
        return
    form = _ANNOTATIONS[name]
    values = [value for keyword, value in annotation.arguments if not keyword]
    if not form.fewest <= len(values) <= form.most:
        expected = "one value" if form.most else "no value"
        message = f"@{name} takes {expected}, found {len(values)}"
        remarks.warning("bad-annotation", annotation.location, message)
    for keyword, value in annotation.arguments:
        if keyword and keyword not in form.keywords:
            message = f"@{name} has no argument '{keyword}'"
            remarks.warning("bad-annotation", value.location, message, suggestion(keyword, form.keywords))
    if form.of_attributes and not isinstance(definition, Attribute | Function):
        remarks.warning("bad-annotation", annotation.location, f"@{name} applies to attributes only")
    if name == "StartRule" and not isinstance(definition, Rule):
        remarks.warning("bad-annotation", annotation.location, "@StartRule marks rules only")
    if name == "Range":
        _check_range(annotation, remarks)


def _check_range(annotation: Annotation, remarks: Remarks) -> None:
    arguments = dict(annotation.arguments)
    values = [constant(value) for keyword, value in annotation.arguments if not keyword]
    low, high = [*values, None, None][:2]
    if "min" in arguments or "max" in arguments:
        low = constant(arguments["min"]) if "min" in arguments else None
        high = constant(arguments["max"]) if "max" in arguments else None
    elif len(values) < 2:
        remarks.warning("bad-annotation", annotation.location, "@Range takes a minimum and a maximum")
    if low is not None and high is not None and not low <= high:
        message = f"the minimum of @Range is above its maximum: {low:g} and {high:g}"
        remarks.warning("bad-annotation", annotation.location, message)
