"""Rule packages are opened with their sources; damaged and hostile ones end with a sentence."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from grammarlab.assets.mesh_files import find_asset
from grammarlab.errors import AssetError, UsageError
from grammarlab.runs.sample import rule_packages
from grammarlab.runs.sample.seven_zip import MAX_FILES, files_of
from grammarlab.runs.sample.shipped import find_rules
from tests.runs.sample.seven_zips import LZMA_PROPERTIES, archive, enclosed, number, parts_of, with_packed_header

RULES = b'import lib : "lib/walls.cga"\n@StartRule\nLot --> extrude(3) lib.Walls\n'
PACKAGE = [
    ("rules/lib/walls.cga", b"Walls --> comp(f) { side : A. }"),
    ("rules/lot.cga", RULES),
    ("bin/lot.cgb", b"\xca\xfe\xba\xbe"),
    ("bin/lot$walls.cgb", b"\xca\xfe\xba\xbe"),
    ("assets/wall.png", bytes(range(256)) * 40),
    (".ws/ESRI.lib/rules/roof.cga", b"Roof --> roofHip(30)"),
    (".ws/ESRI.lib/assets/oak.obj", b"v 0 0 0"),
]


@pytest.fixture(autouse=True)
def temporary_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "tmp"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    return folder


def written(folder: Path, data: bytes) -> Path:
    path = folder / "lot.rpk"
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("compressed", [True, False])
def test_files_are_what_was_packed(tmp_path: Path, compressed: bool) -> None:
    data = archive(PACKAGE, compressed)
    for version in (data, with_packed_header(data)):
        assert [(str(file.name), file.content) for file in files_of(written(tmp_path, version))] == PACKAGE


def test_a_package_gives_its_first_rule_file_with_imports_assets_and_other_projects(tmp_path: Path) -> None:
    path = written(tmp_path, archive(PACKAGE))
    source = find_rules(str(path))
    assert source.path.read_bytes() == RULES
    assert "comp" in source.text()
    assert find_asset("wall.png", source.assets).stat().st_size == 10240
    assert find_asset("/ESRI.lib/assets/oak.obj", source.assets).read_bytes() == b"v 0 0 0"
    assert source.choices.library is not None
    assert Path(source.choices.library, "ESRI.lib", "rules", "roof.cga").is_file()
    assert find_rules(str(path)) == source
    assert source.path.is_relative_to(tmp_path / "tmp")


def test_a_package_without_sources_is_refused_and_not_unpacked(tmp_path: Path, temporary_folder: Path) -> None:
    path = written(tmp_path, archive(PACKAGE[2:5]))
    with pytest.raises(UsageError, match="compiled rules only"):
        find_rules(str(path))
    assert [file for file in temporary_folder.rglob("*") if file.is_file()] == []


def test_several_sources_without_a_first_one_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="which of its 2 rule files"):
        find_rules(str(written(tmp_path, archive(PACKAGE[:2]))))


@pytest.mark.parametrize(
    "name", ["../x.cga", "/etc/x.cga", "rules/../../x", "..\\x.cga", "C:\\x.cga", "rules/\x01.cga", "", "a" * 2000]
)
def test_names_that_lead_out_are_refused_before_anything_is_written(
    tmp_path: Path, temporary_folder: Path, name: str
) -> None:
    path = written(tmp_path, archive([*PACKAGE, (name, b"x")]))
    with pytest.raises(UsageError, match="leads out of its folder"):
        find_rules(str(path))
    assert [file for file in temporary_folder.rglob("*") if file.is_file()] == []


def test_links_are_refused(tmp_path: Path) -> None:
    data = archive([("rules/lot.cga", b"/etc/passwd")], attributes=[0o120777 << 16 | 0x8000])
    with pytest.raises(AssetError, match="link"):
        list(files_of(written(tmp_path, data)))


def test_bombs_end_at_once(tmp_path: Path) -> None:
    begin = time.perf_counter()
    zeros = [("rules/lot.cga", bytes(1 << 20))]
    bombs = {
        "after unpacking": archive(zeros, size=1 << 40),
        "bytes of memory": archive(zeros, properties=b"\x5d\xff\xff\xff\xff"),
        "at most 10,000 files": enclosed(b"", b"\x01\x05" + number(MAX_FILES + 1)),
    }
    for message, data in bombs.items():
        with pytest.raises(AssetError, match=message):
            list(files_of(written(tmp_path, data)))
    assert time.perf_counter() - begin < 2.0


def test_damage_is_a_sentence_or_changes_no_file(tmp_path: Path) -> None:
    data = archive(PACKAGE)
    random = np.random.default_rng(1)
    for _ in range(200):
        damaged = bytearray(data)
        for position in random.integers(0, len(data), random.integers(1, 4)).tolist():
            damaged[position] ^= int(random.integers(1, 256))
        try:
            files = [(str(file.name), file.content) for file in files_of(written(tmp_path, bytes(damaged)))]
        except AssetError:
            continue
        assert files == PACKAGE


def test_headers_of_any_bytes_are_read_or_refused(tmp_path: Path) -> None:
    body, header = parts_of(archive(PACKAGE))
    for length in range(0, len(header) - 2, 7):
        with pytest.raises(AssetError):
            list(files_of(written(tmp_path, enclosed(body, header[:length]))))
    random = np.random.default_rng(2)
    refused = 0
    for _ in range(200):
        changed = bytearray(header)
        changed[int(random.integers(len(changed)))] = int(random.integers(256))
        try:
            list(files_of(written(tmp_path, enclosed(body, bytes(changed)))))
        except AssetError:
            refused += 1
    assert refused > 50


def test_other_methods_are_named(tmp_path: Path) -> None:
    data = archive([("rules/lot.cga", b"x")], properties=LZMA_PROPERTIES + b"\x00")
    with pytest.raises(AssetError, match="another method than LZMA"):
        list(files_of(written(tmp_path, data)))


def test_a_folder_open_to_others_is_not_used(tmp_path: Path, temporary_folder: Path) -> None:
    path = written(tmp_path, archive(PACKAGE))
    find_rules(str(path))
    (folder,) = temporary_folder.iterdir()
    folder.chmod(0o777)
    with pytest.raises(UsageError, match="open to others"):
        rule_packages.open_package(path)
