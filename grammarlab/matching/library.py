"""Templates by name: shipped ones, or those of a file.

Templates from a CGA rule with attributes: wires are the edges of its derivation, parameters are its attributes.

The position of every corner is measured by derivations, one for each attribute, and has to be affine in the attributes:
further derivations, at corners of their ranges and inside, check this.
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
from grammarlab.derivation import compile_grammar, derive
from grammarlab.derivation.program import Program
from grammarlab.errors import FacadeError, LanguageError, UsageError
from grammarlab.files import existing
from grammarlab.language.checking.check import check
from grammarlab.language.checking.percentages import constant
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.syntax_tree import Attribute, Call
from grammarlab.matching.elements import Floats
from grammarlab.matching.template import Template
from grammarlab.matching.template_text import MOST_CHARACTERS, MOST_COUNT, MOST_PARAMETERS, MOST_WIRES, parse_templates

_NARROWEST, _WIDEST = 0.4, 2.5
"""Range of an attribute without @Range, as multiples of its usual value."""
_STEP = 0.02
"""Step of the derivations that measure corners, as a fraction of a range."""
_EXACT = 1e-6
"""Largest deviation from an affine function, metres."""
_MOST_CHECKS = 16
_MOST_TEMPLATES = 100
_MOST_EDGES = 10_000


@dataclass(frozen=True, slots=True)
class _ParameterRange:
    """An attribute that becomes a parameter, or a count."""

    name: str
    usual: float
    low: float
    high: float
    counts: bool = False
    """Whether it only takes integers."""


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
    ranges = [each for attribute in grammar.attributes.values() if (each := _range_of(attribute)) is not None]
    free, counted = ([each for each in ranges if each.counts is counts] for counts in (False, True))
    if not free or len(free) > MOST_PARAMETERS:
        raise FacadeError(
            f"{file}: expected 1 to {MOST_PARAMETERS} attributes with numbers, such as @Range(min=0.5, max=2) "
            f"attr width = 1, found {len(free)}."
        )
    choices = [range(round(each.low), round(each.high) + 1) for each in counted]
    if np.prod([len(each) for each in choices], initial=1.0) > _MOST_TEMPLATES:
        raise FacadeError(f"{file}: its counts make more than {_MOST_TEMPLATES} templates; narrow their @Range.")
    base = file.rpartition("/")[2].removesuffix(".cga")
    counts = [
        tuple((each.name, value) for each, value in zip(counted, values, strict=True)) for values in product(*choices)
    ]
    return tuple(_template(program, base, free, each, file) for each in counts)


def _range_of(attribute: Attribute) -> _ParameterRange | None:
    """The range of an attribute whose value is a positive number, or a random one; None for others."""
    value = attribute.value
    if isinstance(value, Call) and value.function == "rand" and len(value.arguments) == 2:
        ends = [constant(each) for each in value.arguments]
        usual = None if None in ends else sum(each for each in ends if each is not None) / 2.0
    else:
        usual = constant(value) if not attribute.constant else None  # pyright: ignore[reportArgumentType] any other tree is None
    if usual is None or not np.isfinite(usual) or usual <= 0.0:
        return None
    low, high, step = _NARROWEST * usual, _WIDEST * usual, None
    for annotation in attribute.annotations:
        if annotation.name.lower() == "range":
            named = {key: constant(node) for key, node in annotation.arguments if key}
            plain = [constant(node) for key, node in annotation.arguments if not key]
            least, most, step = (
                named.get(key, plain[place] if place < len(plain) else None)
                for place, key in enumerate(("min", "max", "stepsize"))
            )
            low, high = low if least is None else least, high if most is None else most
    counts = step == 1.0 and usual == round(usual) and 0.0 <= low <= high <= MOST_COUNT
    return _ParameterRange(attribute.name, usual, max(low, 1e-3) if not counts else low, high, counts)


def _template(
    program: Program, base: str, free: list[_ParameterRange], counts: tuple[tuple[str, int], ...], file: str
) -> Template:
    fixed = {name: float(value) for name, value in counts}
    usual, low, high = (np.array([getattr(each, end) for each in free]) for end in ("usual", "low", "high"))
    if not ((low < high) & (low <= usual) & (usual <= high)).all():
        place = int(np.argmin((low < high) & (low <= usual) & (usual <= high)))
        raise FacadeError(f"{file}: {free[place].name}: expected a @Range above 0 that contains its value.")
    names = [each.name for each in free]

    def at(values: Floats) -> Floats:
        return _edges(program, {**fixed, **dict(zip(names, values.tolist(), strict=True))}, file)

    edges = _affine(at, usual, low, high, names, file)
    corner, size = _extent(edges, usual)
    edges = edges - corner
    back, kept = _resized(size, low, high, file)
    wires = np.zeros((len(edges), 5, back.shape[1]))
    wires[:, :4] = edges.reshape(-1, 4, 1 + len(free)) @ back
    one = np.eye(back.shape[1])[0]
    # If width and height are attributes themselves, their ranges apply directly.
    gone = [place for place in range(len(free)) if place not in kept and np.count_nonzero(back[1 + place]) > 1]
    limits = [back[1 + place] - low[place] * one for place in gone]
    limits += [high[place] * one - back[1 + place] for place in gone]
    between = size[:, 1:, None] * np.stack([low, high], axis=1)
    text = ",".join(f"{name}={value}" for name, value in counts)
    return Template(
        name=f"{base}[{text}]" if text else base,
        base=base,
        counts=counts,
        parameters=("width", "height", *(_unlike_size(names[place]) for place in kept)),
        usual=np.concatenate([size @ np.append(1.0, usual), usual[kept]]),
        low=np.concatenate([np.maximum(size[:, 0] + between.min(axis=2).sum(axis=1), 1e-3), low[kept]]),
        high=np.concatenate([size[:, 0] + between.max(axis=2).sum(axis=1), high[kept]]),
        wires=wires,
        limits=np.array(limits).reshape(-1, back.shape[1]),
    )


def _affine(
    at: Callable[[Floats], Floats], usual: Floats, low: Floats, high: Floats, names: list[str], file: str
) -> Floats:
    """[E, 2, 2, 1 + D] constant and coefficients of both ends of each edge, without duplicates."""
    start = at(usual)
    found = np.zeros((*start.shape, 1 + len(usual)))
    for place in range(len(usual)):
        other = usual.copy()
        other[place] += _STEP * ((high - low)[place] if usual[place] < (low + high)[place] / 2 else (low - high)[place])
        moved = at(other)
        if moved.shape != start.shape:
            raise FacadeError(_differs(file, names, other, "has other edges"))
        found[..., 1 + place] = (moved - start) / (other - usual)[place]
    found[..., 0] = start - found[..., 1:] @ usual
    random = np.random.default_rng(0)
    corners = random.integers(0, 2, size=(_MOST_CHECKS, len(usual)))
    inside = random.uniform(size=(_MOST_CHECKS // 2, len(usual)))
    for part in [np.zeros(len(usual)), np.ones(len(usual)), *corners, *inside]:
        values = low + part * (high - low)
        moved = at(values)
        if moved.shape != start.shape:
            raise FacadeError(_differs(file, names, values, "has other edges"))
        away = np.abs(found @ np.append(1.0, values) - moved).max(initial=0.0)
        if not away <= _EXACT * max(1.0, float(np.abs(moved).max(initial=0.0))):
            raise FacadeError(_differs(file, names, values, f"deviates by {away:.2g} m from a linear rule"))
    found = found[np.abs(found[:, 1] - found[:, 0]).max(axis=(1, 2), initial=0.0) > _EXACT].round(9) + 0.0
    # Adjacent faces share edges, each in its own direction.
    first = np.array([tuple(each[0].ravel()) <= tuple(each[1].ravel()) for each in found], dtype=bool)
    found = np.unique(np.where(first[:, None, None, None], found, found[:, ::-1]), axis=0)
    if not 1 <= len(found) <= MOST_WIRES:
        raise FacadeError(f"{file}: expected 1 to {MOST_WIRES} edges visible from the front, found {len(found)}.")
    return found


def _unlike_size(name: str) -> str:
    """The name of an attribute other than width and height, which are those of the whole outline."""
    return f"rule_{name}" if name in {"width", "height"} else name


def _differs(file: str, names: list[str], values: Floats, what: str) -> str:
    place = ", ".join(f"{name} = {value:.4g}" for name, value in zip(names, values.tolist(), strict=True))
    return (
        f"{file}: at {place} its outline {what}. In a template, ends of edges are linear in the attributes: "
        "narrow their ranges (@Range(min=…, max=…)), and make numbers of parts attributes with stepsize=1."
    )


def _extent(edges: Floats, usual: Floats) -> tuple[Floats, Floats]:
    """[2, 1 + D] lower left corner and size of the outline."""
    ends = edges.reshape(-1, 2, edges.shape[-1])
    here = ends @ np.append(1.0, usual)
    low, high = (np.stack([ends[find(here[:, axis]), axis] for axis in (0, 1)]) for find in (np.argmin, np.argmax))
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
    if not weights or max(weights) < _EXACT:
        raise FacadeError(
            f"{file}: expected attributes that change its width and its height independently; "
            f"they change the {'width' if np.abs(scaled[0]).max() > _EXACT else 'height'} only, or both together."
        )
    chosen = pairs[int(np.argmax(weights))]
    kept = [place for place in range(number) if place not in chosen]
    one = np.eye(1 + number)
    forward = np.vstack([one[0], size, one[[1 + place for place in kept]]])
    return np.asarray(np.linalg.inv(forward), dtype=np.float64), kept


def _edges(program: Program, attributes: dict[str, float], file: str) -> Floats:
    """[E, 2, 2] edges of the faces of all leaves, seen from +z, in the order of the derivation."""
    forest = derive(program, 1, seed=0, attributes=attributes)
    leaves, meshes = forest.leaves, forest.meshes
    found = [np.zeros((0, 2, 2))]
    for leaf in range(len(leaves)):
        mesh = int(leaves.mesh[leaf])
        points = meshes.points[meshes.mesh_points[mesh] : meshes.mesh_points[mesh + 1]]
        placed = leaves.position[leaf] + (leaves.size[leaf] * points) @ forest.frames[leaves.frame[leaf]].T
        for face in range(int(meshes.mesh_faces[mesh]), int(meshes.mesh_faces[mesh + 1])):
            corners = meshes.corners[meshes.face_offsets[face] : meshes.face_offsets[face + 1]]
            start = placed[corners, :2]
            found.append(np.stack([start, np.roll(start, -1, axis=0)], axis=1))
        if sum(map(len, found)) > _MOST_EDGES:
            raise FacadeError(f"{file}: expected at most {_MOST_EDGES:,} edges of a window, a door or a column.")
    return np.vstack(found)


BASIC = ("rectangle", "arch", "segment_arch", "gable", "pointed_arch", "circle", "trapezium", "cross_window")
SUFFIX = ".template"


@cache
def shipped() -> tuple[Template, ...]:
    """The templates that come with the package."""
    inside = PACKAGE / "grammars"
    folder = inside if inside.is_dir() else PACKAGE.parent / "grammars"
    path = folder / "templates" / f"library{SUFFIX}"
    return parse_templates(path.read_text(encoding="utf-8"), path.name)


def named(names: str) -> tuple[Template, ...]:
    """Templates from comma-separated names or files; `basic` and `all` are shipped lists.

    Raises:
        UsageError: If a name is unknown; with the nearest ones. If a file is too long or not text.
        LanguageError: If a file does not have the format.
        FacadeError: If rules make no template.
    """
    known: dict[str, list[Template]] = {}
    for template in shipped():
        known.setdefault(template.base, []).append(template)
    found: dict[str, Template] = {}
    for name in [each.strip() for each in (names or "basic").split(",") if each.strip()]:
        if name == "all":
            chosen = list(shipped())
        elif name == "basic":
            chosen = [template for each in BASIC for template in known[each]]
        elif name in known:
            chosen = known[name]
        elif (file := existing(name)) is not None and file.is_file():
            reader = templates_of_rules if file.suffix.lower() == ".cga" else parse_templates
            chosen = list(reader(_text(file), file.name))
        else:
            near = get_close_matches(name, [*known, "all", "basic"], 3)
            hint = f"; did you mean {' or '.join(near)}?" if near else ""
            raise UsageError(f"--templates: no file or shipped template has the name {name!r}{hint}")
        found |= {template.name: template for template in chosen}
    if not found:
        raise UsageError("--templates: expected comma-separated names or files, found none.")
    return tuple(found.values())


def _text(path: Path) -> str:
    with path.open("rb") as file:
        content = file.read(4 * MOST_CHARACTERS + 1)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise UsageError(f"{path.name}: expected text in UTF-8.") from error
