"""A run removes what an earlier run wrote, and nothing of anybody else."""

import json
import os
import random
from contextlib import suppress
from dataclasses import replace
from hashlib import sha256
from typing import Any

import pytest

from grammarlab.errors import AssetError, DerivationError, UsageError
from grammarlab.files import sync_files
from grammarlab.runs.sample import models as batches_module
from grammarlab.runs.sample.manifest import read_manifest
from grammarlab.runs.sample.models import cut_batches, models_of
from grammarlab.runs.sample.records import read_record
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.run import sample_run
from tests.runs.grammars import TOWER


def tower(tmp_path, **options: Any):
    values: dict[str, Any] = {"num_models": 3, "image": False, **options}
    return SampleRequest(name="tower", text=TOWER, assets=tmp_path, **values)


def contents(folder):
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def digest(path):
    return sha256(path.read_bytes()).hexdigest()


def manifest_of(folder, files):
    (folder / "manifest.json").write_text(json.dumps({"grammar": {"name": "tower"}, "files": files}))


@pytest.fixture
def victim(tmp_path):
    folder = tmp_path / "victim"
    folder.mkdir()
    (folder / "thesis.txt").write_text("precious")
    (folder / "models.json").write_text("{}")
    (tmp_path / "out").mkdir()
    return folder


def test_a_manifest_does_not_reach_through_links_or_out_of_its_folder_even_with_the_right_hash(tmp_path, victim):
    out = tmp_path / "out"
    (out / "d").symlink_to(victim)
    (out / "link.txt").symlink_to(victim / "thesis.txt")
    (out / "real").mkdir()
    (out / "real" / "d").symlink_to(victim)
    names = ["d/thesis.txt", "link.txt", "real/d/thesis.txt", "../victim/thesis.txt", str(victim / "thesis.txt")]
    names += ["d", "real", "", ".", "/", "a\0b", "x" * 5000, "d/../link.txt", "C:thesis.txt", "\ud800"]
    manifest_of(out, dict.fromkeys(names, digest(victim / "thesis.txt")))
    run = sample_run(tower(tmp_path), out)
    assert (victim / "thesis.txt").read_text() == "precious"
    assert set(run.kept_files) == {"d/thesis.txt", "link.txt", "real/d/thesis.txt", "d", "real"}
    assert (out / "link.txt").is_symlink()


@pytest.mark.parametrize("listed", ["y", "", None, 3, [], {"a": 1}])
def test_a_listed_file_with_another_hash_stays_and_is_reported(tmp_path, listed):
    out = tmp_path / "out"
    out.mkdir()
    (out / "notes.docx").write_text("mine")
    manifest_of(out, {"notes.docx": listed, "missing.txt": "x"})
    run = sample_run(tower(tmp_path), out)
    assert (out / "notes.docx").read_text() == "mine"
    assert run.kept_files == ("notes.docx",)
    assert sample_run(tower(tmp_path), out).kept_files == ()  # the new manifest does not list it


def test_a_changed_model_stays_where_the_new_run_has_none(tmp_path):
    run = sample_run(tower(tmp_path, num_models=5), tmp_path / "out")
    edited = run.folder / "tower-00004.glb"
    edited.write_bytes(b"edited")
    again = sample_run(tower(tmp_path, num_models=2), run.folder)
    assert again.kept_files == ("tower-00004.glb",)
    assert edited.read_bytes() == b"edited"
    assert not (run.folder / "tower-00003.glb").exists()


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("tower-00001.glb", {}),
        ("tower-00001.mtl", {"file_format": "obj"}),
        ("tower.ply", {"file_format": "ply", "single_file": True}),
        ("tower.png", {"image": True, "num_models": 1}),
        ("derivations/00000/nodes.parquet", {}),
    ],
)
def test_a_changed_file_that_the_new_run_would_replace_stops_it_before_anything_is_removed(tmp_path, name, options):
    request = tower(tmp_path, **options)
    folder = sample_run(request, tmp_path / "out").folder
    (folder / name).write_bytes(b"edited")
    before = contents(folder)
    with pytest.raises(UsageError, match=rf"changed after the run.*{name}.*-o"):
        sample_run(request, folder)
    assert contents(folder) == before
    (folder / name).unlink()
    sample_run(request, folder)


@pytest.mark.parametrize("resume", [False, True])
@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("tower-00001.glb", {}),
        ("tower-00002.mtl", {"file_format": "obj"}),
        ("tower-00000_texture_0.png", {"file_format": "obj"}),
        ("tower.ply", {"file_format": "ply", "single_file": True}),
        ("tower.png", {"image": True, "num_models": 1}),
    ],
)
def test_a_file_that_no_run_wrote_is_not_replaced(tmp_path, name, options, resume):
    out = tmp_path / "out"
    out.mkdir()
    (out / name).write_text("mine")
    with pytest.raises(UsageError, match=f"not listed in a manifest, and a new run would replace them: {name}.*-o"):
        sample_run(tower(tmp_path, **options), out, resume=resume)
    assert contents(out) == {name: b"mine"}
    (out / name).unlink()
    folder = sample_run(tower(tmp_path, **options, seed=1), out, resume=resume).folder
    assert contents(folder) == contents(sample_run(tower(tmp_path, **options, seed=1), tmp_path / "fresh").folder)


def test_files_that_a_run_does_not_write_do_not_stop_it(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    others = ["tower-00003.glb", "tower-00001.obj", "tower.glb", "tower.png", "tower-1.glb", "my-tower-00001.glb"]
    for name in others:
        (out / name).write_text("mine")
    for _ in range(2):
        assert sample_run(tower(tmp_path), out).kept_files == ()
        assert {name for name, content in contents(out).items() if content == b"mine"} == set(others)
    with pytest.raises(UsageError, match=r"not listed in a manifest.*: tower-00003.glb"):
        sample_run(tower(tmp_path, num_models=5), out)


@pytest.mark.parametrize("resume", [False, True])
def test_batches_of_a_run_whose_manifest_was_removed_do_not_count(tmp_path, resume):
    single = tower(tmp_path, single_file=True)
    folder = sample_run(single, tmp_path / "out").folder
    for name in ("manifest.json", "tower.glb"):
        (folder / name).unlink()
    sample_run(replace(single, seed=2), folder, resume=resume)
    assert contents(folder) == contents(sample_run(replace(single, seed=2), tmp_path / "fresh").folder)


def test_models_that_a_killed_run_did_not_record_are_reported_or_replaced(tmp_path):
    folder = sample_run(tower(tmp_path, num_models=5), tmp_path / "out").folder
    (folder / "derivations" / "00000" / "models.json").unlink()
    values = json.loads((folder / "manifest.json").read_text())
    (folder / "manifest.json").write_text(json.dumps({**values, "complete": False, "files": {}}))
    assert sample_run(tower(tmp_path, num_models=3), folder).kept_files == ("tower-00003.glb", "tower-00004.glb")
    assert contents(folder).items() > contents(sample_run(tower(tmp_path), tmp_path / "fresh").folder).items()


ENDLESS = "@StartRule\nLot --> A(1)\nA(k) --> case k > 0 : A(k + 1) else : X"


def test_a_run_that_failed_before_its_first_file_leaves_its_folder_to_other_grammars(tmp_path):
    failing = replace(tower(tmp_path), name="endless", text=ENDLESS)
    with pytest.raises(DerivationError):
        sample_run(failing, tmp_path / "out")
    assert list(contents(tmp_path / "out")) == ["manifest.json"]
    (tmp_path / "out" / "tower-00001.glb").write_text("of somebody else")
    with pytest.raises(UsageError, match="not listed"):
        sample_run(tower(tmp_path), tmp_path / "out")
    (tmp_path / "out" / "tower-00001.glb").unlink()
    assert contents(sample_run(tower(tmp_path), tmp_path / "out").folder) == contents(
        sample_run(tower(tmp_path), tmp_path / "fresh").folder
    )


@pytest.mark.parametrize("file", ["endless-00000.glb", "endless.png", "derivations/00000/models.json"])
def test_a_run_that_failed_after_a_file_keeps_its_folder(tmp_path, file):
    with pytest.raises(DerivationError):
        sample_run(replace(tower(tmp_path), name="endless", text=ENDLESS), tmp_path / "out")
    (tmp_path / "out" / file).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / "out" / file).write_text("of the run")
    before = contents(tmp_path / "out")
    with pytest.raises(UsageError, match="holds models of 'endless'"):
        sample_run(tower(tmp_path), tmp_path / "out")
    assert contents(tmp_path / "out") == before


@pytest.mark.parametrize("resume", [False, True])
@pytest.mark.parametrize("name", ["derivations", "derivations/00000"])
def test_derivations_behind_a_link_are_neither_removed_nor_written(tmp_path, victim, name, resume):
    out = tmp_path / "out"
    link = out / name
    link.parent.mkdir(exist_ok=True)
    (victim / "00000").mkdir()
    (victim / "00000" / "models.json").write_text("{}")
    link.symlink_to(victim)
    before = contents(victim)
    with pytest.raises(UsageError, match=f"{name}: expected a folder.*found a link"):
        sample_run(tower(tmp_path), out, resume=resume)
    assert contents(victim) == before


def test_files_of_others_among_the_derivations_stay(tmp_path):
    folder = sample_run(tower(tmp_path), tmp_path / "out").folder
    for name in ("derivations/notes.txt", "derivations/00000/.DS_Store", "derivations/mine/models.json"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text("mine")
    for request in (tower(tmp_path), replace(tower(tmp_path), seed=5)):
        run = sample_run(request, folder)
        assert run.kept_files == ()
        for name in ("derivations/notes.txt", "derivations/00000/.DS_Store", "derivations/mine/models.json"):
            assert (folder / name).read_text() == "mine"
    fresh = sample_run(replace(tower(tmp_path), seed=5), tmp_path / "fresh")
    assert contents(fresh.folder).items() < contents(folder).items()


def test_a_killed_run_without_a_record_is_made_again(tmp_path):
    request = tower(tmp_path)
    whole = contents(sample_run(request, tmp_path / "out").folder)
    (tmp_path / "out" / "derivations" / "00000" / "models.json").unlink()
    values = json.loads((tmp_path / "out" / "manifest.json").read_text())
    (tmp_path / "out" / "manifest.json").write_text(json.dumps({**values, "complete": False, "files": {}}))
    sample_run(request, tmp_path / "out")
    assert contents(tmp_path / "out") == whole


def test_textures_and_libraries_belong_to_the_run(tmp_path):
    from PIL import Image

    Image.new("RGB", (4, 4), "red").save(tmp_path / "wall.png")
    text = 'Lot --> extrude(3) setupProjection(0, scope.xy, 1, 1) texture("wall.png") projectUV(0) Wall'
    for single in (False, True):
        request = SampleRequest(
            name="wall", text=text, assets=tmp_path, file_format="obj", single_file=single, image=False
        )
        run = sample_run(request, tmp_path / "out")
        listed = set(read_manifest(run.manifest).files)
        there = {name for name in contents(run.folder) if name != "manifest.json" and "models.json" not in name}
        assert listed == there
        assert any("_texture_" in name and name.endswith(".png") for name in listed)
        whole = contents(run.folder)
        for name in sorted(listed):
            (run.folder / name).write_bytes(b"cut")
            sample_run(request, run.folder, resume=True)
            assert contents(run.folder) == whole


@pytest.mark.parametrize(
    ("which", "length"),
    [
        ("tower-00001.glb", 0),
        ("tower-00001.glb", 100),
        ("tower-00001.glb", None),
        ("derivations/00000/nodes.parquet", 100),
        ("tower.png", None),
    ],
)
def test_resuming_makes_files_again_that_differ(tmp_path, which, length):
    request = tower(tmp_path, num_models=2, image=which == "tower.png")
    folder = sample_run(request, tmp_path / "out").folder
    whole = contents(folder)
    content = whole[which]
    (folder / which).write_bytes(content[:length] if length is not None else bytes([content[0] ^ 1]) + content[1:])
    sample_run(request, folder, resume=True)
    assert contents(folder) == whole


def test_resuming_makes_only_the_damaged_batch_again(tmp_path, monkeypatch):
    monkeypatch.setattr(batches_module, "BATCH_MODELS", 2)
    request = tower(tmp_path, num_models=6)
    folder = sample_run(request, tmp_path / "out").folder
    whole = contents(folder)
    times = {path: path.stat().st_mtime_ns for path in folder.glob("*.glb")}
    with (folder / "tower-00002.glb").open("r+b") as file:
        file.truncate(100)
    sample_run(request, folder, resume=True)
    assert contents(folder) == whole
    renewed = {path.name for path, time in times.items() if path.stat().st_mtime_ns != time}
    assert renewed == {"tower-00002.glb", "tower-00003.glb"}


def test_every_file_is_on_the_disk_before_the_record_that_names_it(tmp_path, monkeypatch):
    flushed, named = set(), []
    real = os.fsync

    def fsync(descriptor):
        real(descriptor)
        status = os.fstat(descriptor)
        flushed.add((status.st_dev, status.st_ino))

    def is_flushed(path):
        status = path.stat()
        return (status.st_dev, status.st_ino) in flushed

    def sync(files, folder):
        paths = list(files)
        sync_files(paths, folder)
        named.extend([*paths, *(path.parent for path in paths)])
        assert all(map(is_flushed, named))
        assert not (folder / "derivations" / "00000" / "models.json").exists()

    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr("grammarlab.runs.sample.records.sync_files", sync)
    run = sample_run(tower(tmp_path), tmp_path / "out")
    record = run.folder / "derivations" / "00000" / "models.json"
    files = {run.folder / name for name in read_manifest(run.manifest).files}
    assert files <= set(named)
    assert all(map(is_flushed, [record, run.manifest, *files]))


def test_two_runs_at_once_do_not_share_a_folder(tmp_path):
    refused = []

    def second(_what, _done, _total):
        with pytest.raises(UsageError, match=f"another run is writing into {tmp_path / 'out'}"):
            sample_run(tower(tmp_path, seed=1), tmp_path / "out")
        refused.append(True)

    run = sample_run(tower(tmp_path), tmp_path / "out", on_progress=second)
    assert refused
    assert contents(run.folder) == contents(sample_run(tower(tmp_path), tmp_path / "alone").folder)


WRONG = [None, True, -1, 0, 1.5, 1e308, 10**400, "x", "", "\0", "../x", [], [1], ["x"], {}, {"a": 1}, [[]], [{}]]


def positions(value, path=()):
    """The position of every value of a JSON document."""
    yield path
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, entry in entries:
        yield from positions(entry, (*path, key))


def with_value(document, path, value):
    if not path:
        return value
    copy = dict(document) if isinstance(document, dict) else list(document)
    copy[path[0]] = with_value(document[path[0]], path[1:], value)
    return copy


def test_a_manifest_with_any_value_of_another_type_is_read_or_refused_in_words(tmp_path):
    request = tower(tmp_path, attributes={"height": 4.0})
    footprint = SampleRequest.of("toy", footprint="5x5").footprints
    run = sample_run(replace(request, footprints=footprint, num_models=1), tmp_path / "out")
    values = json.loads(run.manifest.read_text())
    messages = []
    for path in positions(values):
        for wrong in WRONG:
            run.manifest.write_text(json.dumps(with_value(values, path, wrong)))
            try:
                changed = read_manifest(run.manifest, tmp_path).request
            except AssetError as error:
                messages.append(str(error))
                continue
            if path[:1] == ("request",):
                with suppress(UsageError):  # such as an unknown attribute
                    models_of(changed).check(changed)
    assert len(messages) > 100
    assert all(str(run.manifest) in message for message in messages)


def test_a_record_with_any_value_of_another_type_is_made_again(tmp_path):
    request = tower(tmp_path, num_models=1)
    run = sample_run(request, tmp_path / "out")
    (batch,) = cut_batches(request)
    record = run.folder / "derivations" / "00000" / "models.json"
    values = json.loads(record.read_text())
    rand = random.Random(1)
    mutants = [with_value(values, path, wrong) for path in positions(values) for wrong in WRONG]
    usable = []
    for mutant in mutants:
        record.write_text(json.dumps(mutant))
        found = read_record(run.folder, request, batch)
        if found is not None:
            assert [model.index for model in found.models] == [0]
            usable.append(mutant)
    for mutant in rand.sample(mutants, 10) + rand.sample(usable, 5):
        record.write_text(json.dumps(mutant))
        sample_run(request, run.folder, resume=True)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize("resume", [False, True])
@pytest.mark.parametrize(
    "name", ["tower-00001.glb", "derivations/00000/models.json", "derivations/00000/nodes.parquet"]
)
def test_a_pipe_in_the_folder_of_a_run_is_not_waited_for(tmp_path, name, resume):
    folder = sample_run(tower(tmp_path), tmp_path / "out").folder
    (folder / name).unlink()
    os.mkfifo(folder / name)
    if not resume and not name.endswith("models.json"):
        with pytest.raises(UsageError, match="changed after the run"):
            sample_run(tower(tmp_path), folder)
        return
    sample_run(tower(tmp_path), folder, resume=resume)
    assert (folder / "tower-00001.glb").is_file()
