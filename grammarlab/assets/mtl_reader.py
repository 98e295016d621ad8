"""Materials of MTL files: diffuse colour and image, opacity, and the metalness, roughness and light of newer files."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grammarlab.assets.mesh_parts import PartMaterial, color_of

_OPTIONS = {
    b"-blendu": 1,
    b"-blendv": 1,
    b"-bm": 1,
    b"-boost": 1,
    b"-cc": 1,
    b"-clamp": 1,
    b"-imfchan": 1,
    b"-mm": 2,
    b"-o": 3,
    b"-s": 3,
    b"-t": 3,
    b"-texres": 1,
}
"""Options of images and their largest numbers of values; ``-o``, ``-s`` and ``-t`` may have fewer."""
_WHITE = [b"1", b"1", b"1"]


def read_mtl(content: bytes) -> dict[bytes, PartMaterial | None]:
    r"""Materials by their names; None for those without a colour and an image.

    >>> read_mtl(b"newmtl a\nKd 1 0 0\nmap_Kd -s 2 2 my bricks.jpg")[b"a"].texture
    'my bricks.jpg'
    """
    return {name: _material(of_name) for name, of_name in _statements(content).items()}


def first_material(content: bytes) -> PartMaterial | None:
    """The first material with a colour or an image; None if there is none. Those after it are not read."""
    materials = map(_material, _statements(content).values())
    return next((material for material in materials if material is not None), None)


def _statements(content: bytes) -> dict[bytes, dict[bytes, list[bytes]]]:
    """Words of each statement of each material, by their names."""
    statements: dict[bytes, dict[bytes, list[bytes]]] = {}
    material: dict[bytes, list[bytes]] = {}
    for line in content.replace(b"\r", b"\n").split(b"\n"):
        words = line.split()
        if len(words) < 2:
            continue
        if words[0] == b"newmtl":
            material = statements.setdefault(b" ".join(words[1:]), {})
        else:
            material[words[0].lower()] = words[1:]
    return statements


def _material(statements: dict[bytes, list[bytes]]) -> PartMaterial | None:
    texture = _image(statements.get(b"map_kd", []))
    color = statements.get(b"kd", _WHITE if texture else [])
    if texture and all(_number(word, 1.0) == 0.0 for word in color[:3]):
        color = _WHITE  # Maya writes black where the image has the colour; CityEngine reads it in this way, too.
    if b"d" in statements:
        opacity = statements[b"d"][-1:]
    else:
        transparency = _number(statements.get(b"tr", [b"0"])[-1], 0.0)
        # Some programs write the opacity here, and nobody an invisible surface.
        opacity = [str(1.0 - transparency % 1.0).encode()]
    channels = color_of([*color[:3], *opacity]) if len(color) >= 3 else None
    if channels is None:
        return None
    light = [_number(word, 0.0) for word in statements.get(b"ke", [])[:3]]
    return PartMaterial(
        channels,
        texture,
        metallic=_number(statements.get(b"pm", [b"0"])[0], 0.0),
        roughness=_number(statements.get(b"pr", [b"0.8"])[0], 0.8),
        emissive=(light[0], light[1], light[2]) if len(light) == 3 else (0.0, 0.0, 0.0),
        is_cut_out=b"map_d" in statements,
    )


def _image(words: Sequence[bytes]) -> str:
    """File of an image, without the options before it; names may have spaces."""
    first = 0
    while first < len(words) - 1 and words[first].lower() in _OPTIONS:
        most = _OPTIONS[words[first].lower()]
        first += 1
        values = 0
        while values < most and first < len(words) - 1 and (values == 0 or _is_number(words[first])):
            first, values = first + 1, values + 1
    return b" ".join(words[first:]).decode("utf-8", errors="replace")


def _is_number(word: bytes) -> bool:
    return not np.isnan(_number(word, np.nan))


def _number(word: bytes, otherwise: float) -> float:
    """A number clipped to 0..1; other words mean `otherwise`."""
    try:
        value = float(word)
    except ValueError:
        return otherwise
    return min(max(value, 0.0), 1.0) if np.isfinite(value) else otherwise
