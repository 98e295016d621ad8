"""Ids of parcels: the same for every format and order."""

from __future__ import annotations

import unicodedata

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.city.parcel_ids import canonical_id, identities, part_ids
from grammarlab.errors import UsageError

names = st.one_of(st.none(), st.text(max_size=8), st.integers(-(2**60), 2**60), st.floats(allow_nan=False))


@given(names)
def test_the_canonical_form_is_its_own(value):
    text = canonical_id(value)
    assert canonical_id(text) == text
    assert text == text.strip() == unicodedata.normalize("NFC", text)


@given(st.integers(-(2**52), 2**52))
def test_numbers_are_the_same_as_texts_and_floats(number):
    """dBASE tables have floats where other formats have whole numbers."""
    forms = {canonical_id(form) for form in (number, float(number), str(number), f"{number}.0", f" {number}.000")}
    assert forms == {str(number)}


def test_leading_zeros_and_letters_stay():
    assert [canonical_id(text) for text in ("007", "007.0", "1.50", "1.0.0", "A.0", "e\u0301")] == [
        "007",
        "007",
        "1.50",
        "1.0.0",
        "A.0",
        "\u00e9",
    ]
    assert canonical_id("x" * 201) == ""


@given(st.lists(st.tuples(names, st.binary(max_size=2)), max_size=12), st.randoms(use_true_random=False))
def test_ids_are_different_and_follow_their_rows(rows, random):
    def ids(order):
        lots = [canonical_id(rows[row][0]) for row in order]
        table = pa.table({"lot": pa.array(lots, pa.string()), "row": pa.array(order, pa.int64())})
        return identities(table, [rows[row][1] for row in order], "lot", "map").id.tolist()

    order = [*range(len(rows))]
    shuffled = random.sample(order, len(order))
    first = ids(order)
    assert len(set(first)) == len(first)
    assert [first[row] for row in shuffled] == ids(shuffled)


def test_parts_are_numbered():
    ids = np.array(["a", "b"], dtype=object)
    assert part_ids(ids, np.array([1, 3])).tolist() == ["a", "b#1", "b#2", "b#3"]


def test_unknown_attributes_are_named():
    with pytest.raises(UsageError, match=r"map: no attribute 'plot' for ids; its attributes are 'lot'\."):
        identities(pa.table({"lot": ["1"]}), [b""], "plot", "map")
