"""Hashes of designs in labels."""

import hashlib
import json

from grammarlab.language.grammar import hash_of
from grammarlab.learning.designs.addresses import hashes_of, renamed
from grammarlab.preference.labels import Label, Labels

TEXT = "Lot --> 40% : A\n    else : B\n"
WINDOWS = hashlib.sha256(TEXT.replace("\n", "\r\n").encode()).hexdigest()


def labels(text_hash: str) -> Labels:
    own, flat = hashes_of(text_hash)
    other = json.dumps({"seed": 1, "model": 3, "grammar": flat}, separators=(",", ":"))
    return Labels(
        (
            Label(1, 2, "a", 80.0, own),
            Label(1, 2, "a", 0.0, flat),
            Label(1, 2, "a", 100.0, own, kind="rather", other=other),
            Label(1, 2, "a", 80.0, "f" * 64),
        )
    )


def test_labels_of_a_file_with_windows_line_ends_are_about_its_text():
    expected = labels(hash_of(TEXT))
    for text in (TEXT, TEXT.replace("\n", "\r\n")):
        assert renamed(labels(WINDOWS), text) == expected
        assert renamed(expected, text) is expected


def test_labels_of_another_text_stay_so():
    foreign = labels(hash_of("Lot --> NIL"))
    assert renamed(foreign, TEXT) is foreign
