"""Values of JSON files of any size: the same as of the whole document."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.errors import AssetError
from grammarlab.geometry.footprints import json_stream
from grammarlab.geometry.footprints.json_stream import Damage, Document, Item, Member, json_parts

PATH = Path("lots.geojson")
scalars = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(allow_nan=False), st.text())
values = st.recursive(scalars, lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner), max_leaves=8)
SIZES = st.sampled_from([2, 3, 7, 64, 4096])


def parts(content: bytes, block: int = 16):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(json_stream, "_BLOCK_BYTES", block)
        return list(json_parts(PATH, io.BytesIO(content), "features"))


@settings(max_examples=50)
@given(st.dictionaries(st.text(), values), st.lists(values), SIZES, st.sampled_from([None, 2]), st.booleans())
def test_a_document_is_its_members_and_items(members, items, block, indent, is_utf_16):
    document = {key: value for key, value in members.items() if key != "features"} | {"features": items, "crs": None}
    text = json.dumps(document, indent=indent, ensure_ascii=False)
    text = "".join(" " if 0xD800 <= ord(letter) < 0xE000 else letter for letter in text)
    expected = json.loads(text)
    if indent is None:
        text = f" {text}"
    found = parts(text.encode("utf-16" if is_utf_16 else "utf-8-sig"), block)
    if len(found) == 1 and isinstance(found[0], Document):
        assert found[0].value == expected
        return
    assert [part.value for part in found if isinstance(part, Item)] == expected.pop("features")
    assert {part.name: part.value for part in found if isinstance(part, Member)} == expected


@given(st.lists(st.dictionaries(st.text(), scalars), min_size=2), SIZES, st.sampled_from(["\n", "\x1e", "\r\n"]))
def test_lines_and_records_are_documents(documents, block, separator):
    texts = [json.dumps(document) for document in documents]
    content = "".join(f"{separator}{text}" for text in texts) if separator == "\x1e" else separator.join(texts)
    found = parts(content.encode(), max(block, 4096))
    assert [part.value for part in found if isinstance(part, Document)] == [json.loads(text) for text in texts]


def test_broken_lines_are_numbered_and_the_others_read():
    found = parts(b'{"a": 1}\n{"a": \n\n[' + b"[" * 100_000 + b'\n{"a": 2}', 1 << 20)
    assert [part.value for part in found if isinstance(part, Document)] == [{"a": 1}, {"a": 2}]
    assert [part.number for part in found if isinstance(part, Damage)] == [2, 4]


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"  \n ",
        b"{",
        b"[",
        b'{"features": [1, 2}',
        b'{"features": [1 2]}',
        b'{"a" 1}',
        b"{1: 2}",
        b'{"a": 1,}',
        b"[1] [2]",
        b"nonsense",
        b"\xff\xfe\x00",
        b"\x80",
        b"[" * 100_000,
    ],
)
def test_broken_documents_are_refused(content):
    with pytest.raises(AssetError, match=r"lots\.geojson: expected"):
        parts(content)


def test_values_are_bounded(monkeypatch):
    monkeypatch.setattr(json_stream, "_MAX_VALUE", 100)
    with pytest.raises(AssetError, match="at most 100 characters"):
        parts(b'["' + b"x" * 1000 + b'"]')
    assert len(parts(b"[" + b"1," * 1000 + b"1]")) == 1001
