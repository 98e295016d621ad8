"""Templates by name: shipped ones, those of a file, or the start rule of a CGA file with attributes.

The wires of a rule's template are the edges of its derivation, its parameters are the attributes. The position of every
corner is measured by derivations, one for each attribute, and has to be affine in the attributes: further derivations,
at corners of their ranges and inside, check this.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np

from grammarlab.about import PACKAGE
from grammarlab.arrays import Floats
from grammarlab.derivation import compile_grammar, derive
from grammarlab.derivation.program import Program
from grammarlab.errors import FacadeError, LanguageError, UsageError
from grammarlab.files import existing
from grammarlab.language.checking.check import check
from grammarlab.language.checking.percentages import constant
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.syntax_tree import Attribute, Call
from grammarlab.matching.template import Template
from grammarlab.matching.template_text import MOST_CHARACTERS, MOST_COUNT, MOST_PARAMETERS, MOST_WIRES, parse_templates

_BASIC = ("rectangle", "arch", "segment_arch", "gable", "pointed_arch", "circle", "trapezium", "cross_window")
"""Bases of the templates of the list `basic`."""
_MIN_RATIO, _MAX_RATIO = 0.4, 2.5
"""Range of an attribute without @Range, as multiples of its usual value."""
_STEP_SHARE = 0.02
"""Step of the derivations that measure corners, as a fraction of a range."""
_TOLERANCE_M = 1e-6
"""Largest deviation from an affine function, metres."""
_NUM_CHECKS = 16
"""Number of corners of the ranges that are checked, and twice the number of points inside them."""
_MAX_TEMPLATES = 100
"""Largest number of templates of a file of rules."""
_MAX_EDGES = 10_000
"""Largest number of edges of a derivation."""


def templates_by_name(names: str) -> tuple[Template, ...]:
    """Templates from comma-separated names or files; `basic` and `all` are shipped lists.

    Raises:
        UsageError: If a name is unknown; with the nearest ones. If a file is too long or not text.
        LanguageError: If a file does not have the format.
        FacadeError: If rules make no template.
    """
    by_base: dict[str, list[Template]] = {}
    for template in shipped():
        by_base.setdefault(template.base, []).append(template)
    selected: dict[str, Template] = {}
    for name in [part.strip() for part in (names or "basic").split(",") if part.strip()]:
        if name == "all":
            chosen = list(shipped())
        elif name == "basic":
            chosen = [template for base in _BASIC for template in by_base[base]]
        elif name in by_base:
            chosen = by_base[name]
        elif (file := existing(name)) is not None and file.is_file():
            reader = templates_of_rules if file.suffix.lower() == ".cga" else parse_templates
            chosen = list(reader(_text(file), file.name))
        else:
            near = get_close_matches(name, [*by_base, "all", "basic"], 3)
            hint = f"; did you mean {' or '.join(near)}?" if near else ""
            raise UsageError(f"`templates=`: no file or shipped template has the name {name!r}{hint}")
        selected |= {template.name: template for template in chosen}
    if not selected:
        raise UsageError("`templates=`: expected comma-separated names or files, found none.")
    return tuple(selected.values())


@cache
def shipped() -> tuple[Template, ...]:
    """The templates that come with the package."""
    inside = PACKAGE / "grammars"
    folder = inside if inside.is_dir() else PACKAGE.parent / "grammars"
    path = folder / "templates" / "library.template"
    return parse_templates(path.read_text(encoding="utf-8"), path.name)


def templates_of_rules(text: str, file: str) -> tuple[Template, ...]:
    """The template of the start rule of a rule file, one for each value of each count.

    Parameters are the numeric attributes with ``@Range(min, max)``, or without it with a range of 0.4 to 2.5 times
    their value; ``@Range(min, max, stepsize=1)`` makes a count. Width and height are those of the whole outline; each
    replaces an attribute that changes it. The outline is seen from +z.

    Raises:
        LanguageError: If rules have errors.
        FacadeError: If rules have no edges or attributes, or edges are not affine in the attributes.
    """
    grammar = Grammar.parse(text, file)
    errors = tuple(finding for finding in check(grammar) if finding.severity == "error")
    if errors:
        raise LanguageError(errors, text)
    program = compile_grammar(grammar)
    ranges = [parameter for attribute in grammar.attributes.values() if (parameter := _range_of(attribute)) is not None]
    free, counted = ([parameter for parameter in ranges if parameter.counts is counts] for counts in (False, True))
    if not free or len(free) > MOST_PARAMETERS:
        raise FacadeError(
            f"{file}: expected 1 to {MOST_PARAMETERS} attributes with numbers, such as @Range(min=0.5, max=2) "
            f"attr width = 1, found {len(free)}."
        )
    choices = [range(round(parameter.low), round(parameter.high) + 1) for parameter in counted]
    if np.prod([len(choice) for choice in choices], initial=1.0) > _MAX_TEMPLATES:
        raise FacadeError(f"{file}: its counts make more than {_MAX_TEMPLATES} templates; narrow their @Range.")
    base = file.rpartition("/")[2].removesuffix(".cga")
    counts = [
        tuple((parameter.name, value) for parameter, value in zip(counted, values, strict=True))
        for values in product(*choices)
    ]
    return tuple(_template(program, base, free, combination, file) for combination in counts)


def _range_of(attribute: Attribute) -> _ParameterRange | None:
    """The range of an attribute whose value is a positive number, or a random one; None for others."""
    value = attribute.value
    if isinstance(value, Call) and value.function == "rand" and len(value.arguments) == 2:
        ends = [constant(argument) for argument in value.arguments]
        usual = None if None in ends else sum(end for end in ends if end is not None) / 2.0
    else:
        usual = constant(value) if not attribute.constant else None  # ty: ignore[invalid-argument-type]  # pyright: ignore[reportArgumentType] any other tree is None
    if usual is None or not np.isfinite(usual) or usual <= 0.0:
        return None
    low, high, step = _MIN_RATIO * usual, _MAX_RATIO * usual, None
    for annotation in attribute.annotations:
        if annotation.name.lower() == "range":
            named = {key: constant(node) for key, node in annotation.arguments if key}
            plain = [constant(node) for key, node in annotation.arguments if not key]
            least, most, step = (
                named.get(key, plain[index] if index < len(plain) else None)
                for index, key in enumerate(("min", "max", "stepsize"))
            )
            low, high = low if least is None else least, high if most is None else most
    counts = step == 1.0 and usual == round(usual) and 0.0 <= low <= high <= MOST_COUNT
    return _ParameterRange(attribute.name, usual, max(low, 1e-3) if not counts else low, high, counts)


@dataclass(frozen=True, slots=True)
class _ParameterRange:
    """An attribute that becomes a parameter, or a count."""

    name: str
    usual: float
    low: float
    high: float
    counts: bool = False
    """Whether it only takes integers."""


def _template(
    program: Program, base: str, free: list[_ParameterRange], counts: tuple[tuple[str, int], ...], file: str
) -> Template:
    fixed = {name: float(value) for name, value in counts}
    usual, low, high = (np.array([getattr(parameter, end) for parameter in free]) for end in ("usual", "low", "high"))
    if not ((low < high) & (low <= usual) & (usual <= high)).all():
        index = int(np.argmin((low < high) & (low <= usual) & (usual <= high)))
        raise FacadeError(f"{file}: {free[index].name}: expected a @Range above 0 that contains its value.")
    names = [parameter.name for parameter in free]

    def edges_at(values: Floats) -> Floats:
        return _edges(program, {**fixed, **dict(zip(names, values.tolist(), strict=True))}, file)

    edges = _affine(edges_at, usual, low, high, names, file)
    corner, size = _extent(edges, usual)
    edges = edges - corner
    back, remaining = _resized(size, low, high, file)
    wires = np.zeros((len(edges), 5, back.shape[1]))
    wires[:, :4] = edges.reshape(-1, 4, 1 + len(free)) @ back
    unit = np.eye(back.shape[1])[0]
    # If width and height are attributes themselves, their ranges apply directly.
    replaced = [index for index in range(len(free)) if index not in remaining and np.count_nonzero(back[1 + index]) > 1]
    limits = [back[1 + index] - low[index] * unit for index in replaced]
    limits += [high[index] * unit - back[1 + index] for index in replaced]
    between = size[:, 1:, None] * np.stack([low, high], axis=1)
    text = ",".join(f"{name}={value}" for name, value in counts)
    return Template(
        name=f"{base}[{text}]" if text else base,
        base=base,
        counts=counts,
        parameters=("width", "height", *(_unlike_size(names[index]) for index in remaining)),
        usual=np.concatenate([size @ np.append(1.0, usual), usual[remaining]]),
        low=np.concatenate([np.maximum(size[:, 0] + between.min(axis=2).sum(axis=1), 1e-3), low[remaining]]),
        high=np.concatenate([size[:, 0] + between.max(axis=2).sum(axis=1), high[remaining]]),
        wires=wires,
        limits=np.array(limits).reshape(-1, back.shape[1]),
    )


def _edges(program: Program, attributes: dict[str, float], file: str) -> Floats:
    """[E, 2, 2] edges of the faces of all leaves, seen from +z, in the order of the derivation."""
    forest = derive(program, 1, seed=0, attributes=attributes)
    leaves, meshes = forest.leaves, forest.meshes
    edges = [np.zeros((0, 2, 2))]
    for leaf in range(len(leaves)):
        mesh = int(leaves.mesh[leaf])
        points = meshes.points[meshes.mesh_points[mesh] : meshes.mesh_points[mesh + 1]]
        placed = leaves.position[leaf] + (leaves.size[leaf] * points) @ forest.frames[leaves.frame[leaf]].T
        for face in range(int(meshes.mesh_faces[mesh]), int(meshes.mesh_faces[mesh + 1])):
            corners = meshes.corners[meshes.face_offsets[face] : meshes.face_offsets[face + 1]]
            start = placed[corners, :2]
            edges.append(np.stack([start, np.roll(start, -1, axis=0)], axis=1))
        if sum(map(len, edges)) > _MAX_EDGES:
            raise FacadeError(f"{file}: expected at most {_MAX_EDGES:,} edges of a window, a door or a column.")
    return np.vstack(edges)


def _affine(
    edges_at: Callable[[Floats], Floats], usual: Floats, low: Floats, high: Floats, names: list[str], file: str
) -> Floats:
    """[E, 2, 2, 1 + D] constant and coefficients of both ends of each edge, without duplicates."""
    start = edges_at(usual)
    coefficients = np.zeros((*start.shape, 1 + len(usual)))
    for index in range(len(usual)):
        other = usual.copy()
        other[index] += _STEP_SHARE * (
            (high - low)[index] if usual[index] < (low + high)[index] / 2 else (low - high)[index]
        )
        moved = edges_at(other)
        if moved.shape != start.shape:
            raise FacadeError(_differs(file, names, other, "has other edges"))
        coefficients[..., 1 + index] = (moved - start) / (other - usual)[index]
    coefficients[..., 0] = start - coefficients[..., 1:] @ usual
    random = np.random.default_rng(0)
    corners = random.integers(0, 2, size=(_NUM_CHECKS, len(usual)))
    inside = random.uniform(size=(_NUM_CHECKS // 2, len(usual)))
    for part in [np.zeros(len(usual)), np.ones(len(usual)), *corners, *inside]:
        values = low + part * (high - low)
        moved = edges_at(values)
        if moved.shape != start.shape:
            raise FacadeError(_differs(file, names, values, "has other edges"))
        away = np.abs(coefficients @ np.append(1.0, values) - moved).max(initial=0.0)
        if not away <= _TOLERANCE_M * max(1.0, float(np.abs(moved).max(initial=0.0))):
            raise FacadeError(_differs(file, names, values, f"deviates by {away:.2g} m from a linear rule"))
    length = np.abs(coefficients[:, 1] - coefficients[:, 0]).max(axis=(1, 2), initial=0.0)
    coefficients = coefficients[length > _TOLERANCE_M].round(9) + 0.0
    # Adjacent faces share edges, each in its own direction.
    first = np.array([tuple(edge[0].ravel()) <= tuple(edge[1].ravel()) for edge in coefficients], dtype=bool)
    coefficients = np.unique(np.where(first[:, None, None, None], coefficients, coefficients[:, ::-1]), axis=0)
    if not 1 <= len(coefficients) <= MOST_WIRES:
        raise FacadeError(
            f"{file}: expected 1 to {MOST_WIRES} edges visible from the front, found {len(coefficients)}."
        )
    return coefficients


def _differs(file: str, names: list[str], values: Floats, difference: str) -> str:
    position = ", ".join(f"{name} = {value:.4g}" for name, value in zip(names, values.tolist(), strict=True))
    return (
        f"{file}: at {position} its outline {difference}. In a template, ends of edges are linear in the attributes: "
        "narrow their ranges (@Range(min=…, max=…)), and make numbers of parts attributes with stepsize=1."
    )


def _extent(edges: Floats, usual: Floats) -> tuple[Floats, Floats]:
    """[2, 1 + D] lower left corner and size of the outline."""
    ends = edges.reshape(-1, 2, edges.shape[-1])
    usual_ends = ends @ np.append(1.0, usual)
    low, high = (
        np.stack([ends[find(usual_ends[:, axis]), axis] for axis in (0, 1)]) for find in (np.argmin, np.argmax)
    )
    return low, high - low


def _resized(size: Floats, low: Floats, high: Floats, file: str) -> tuple[Floats, list[int]]:
    """[1 + D, 1 + D] old constants and attributes from new ones: 1, width, height and the attributes that remain.

    Args:
        size: [2, 1 + D] width and height as linear forms of the attributes.
        low: [D] least values of the attributes.
        high: [D] largest values of the attributes.
        file: name of the file, for messages.
    """
    number = len(low)
    scaled = size[:, 1:] * (high - low)
    pairs = [(first, second) for first in range(number) for second in range(number) if first != second]
    weights = [abs(float(np.linalg.det(scaled[:, list(pair)]))) for pair in pairs]
    if not weights or max(weights) < _TOLERANCE_M:
        raise FacadeError(
            f"{file}: expected attributes that change its width and its height independently; "
            f"they change the {'width' if np.abs(scaled[0]).max() > _TOLERANCE_M else 'height'} only, or both together."
        )
    chosen = pairs[int(np.argmax(weights))]
    remaining = [index for index in range(number) if index not in chosen]
    identity = np.eye(1 + number)
    forward = np.vstack([identity[0], size, identity[[1 + index for index in remaining]]])
    return np.asarray(np.linalg.inv(forward), dtype=np.float64), remaining


def _unlike_size(name: str) -> str:
    """The name of an attribute other than width and height, which are those of the whole outline."""
    return f"rule_{name}" if name in {"width", "height"} else name


def _text(path: Path) -> str:
    with path.open("rb") as file:
        content = file.read(4 * MOST_CHARACTERS + 1)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise UsageError(f"{path.name}: expected text in UTF-8.") from error
