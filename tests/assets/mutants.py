"""Broken mesh files: cut, with flipped bits, and with other counts."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import trimesh

from tests.assets.documents import rich_document

OBJ = b"mtllib a.mtl\nv 0 0 0\nv 9 0 0\nv 9 0 7\nv 0 0 7\nvt 0 0\nvn 0 -1 0\nusemtl a\n"
OBJ += b"f 1/1/1 2//1 3\nf -4 -2 -1\nl 1 2\n"
OBJ_MUTANTS = [
    OBJ.replace(b" 0\n", b"\n"),
    OBJ.replace(b" 7\n", b" 7 1 0.5 0.5 0.5\n"),
    OBJ.replace(b"\n", b"\r\n"),
    OBJ.replace(b"f 1", b"f \\\n1"),
    OBJ.replace(b"v 9 0 0", b"v nan 0 0"),
    OBJ.replace(b"v 9 0 0", b"v 1e999 0 0"),
    OBJ.replace(b"v 9 0 0", b"v 9,0 0 0"),
    OBJ.replace(b"f -4", b"f -5"),
    OBJ.replace(b"f 1/1/1", b"f 99999999999999999999"),
    OBJ.replace(b" -1\n", b"\n"),
    OBJ.replace(b"v", b"\0v"),
    OBJ.replace(b"f ", b"surf "),
    OBJ.replace(b"a.mtl", b"../../../etc/passwd"),
    b"\xff\xfe" + OBJ.decode().encode("utf-16-le"),
]


def whole_files() -> Iterator[tuple[str, bytes]]:
    """Files of each format, with their suffixes."""
    mesh: Any = trimesh.creation.box((9.0, 0.4, 7.0))
    yield ".obj", OBJ
    yield ".glb", rich_document().glb()
    yield ".gltf", rich_document().gltf()
    yield ".ply", mesh.export(file_type="ply")
    yield ".ply", mesh.export(file_type="ply", encoding="ascii")
    yield ".off", mesh.export(file_type="off").encode()
    yield ".stl", mesh.export(file_type="stl")
    yield ".stl", mesh.export(file_type="stl_ascii").encode()


def mutants(suffixes: tuple[str, ...], num_each: int = 12) -> Iterator[tuple[str, bytes]]:
    """Broken files with some suffixes; the same ones in each call."""
    random = np.random.default_rng(7)
    if ".obj" in suffixes:
        yield from ((".obj", content) for content in OBJ_MUTANTS)
    for suffix, content in whole_files():
        if suffix not in suffixes:
            continue
        numbers = [match.span() for match in re.finditer(rb"\d+", content[:2_000])] or [(80, 84)]
        for _ in range(num_each):
            position = int(random.integers(len(content)))
            flipped = bytearray(content)
            flipped[position] ^= 1 << int(random.integers(8))
            start, end = numbers[int(random.integers(len(numbers)))]
            count = [b"-1", b"0", b"99", b"999999999999", b"1e9", b"nan"][int(random.integers(6))]
            yield from ((suffix, each) for each in (content[:position], bytes(flipped)))
            yield suffix, content[:start] + count + content[end:]
