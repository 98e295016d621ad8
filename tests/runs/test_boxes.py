"""Designs that are no grammars: files of boxes are sampled, scored and learned from like rule files."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from pyarrow import parquet

from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.targets.writers import Making
from grammarlab.pages.record.store import Store
from grammarlab.pages.scoring.session import Session
from grammarlab.preference.label_files import read_labels, save_labels
from grammarlab.preference.labels import OVERALL, Labels
from grammarlab.runs.learn.density_pages import page_of_labels
from grammarlab.runs.learn.from_labels import learn_from_labels
from grammarlab.runs.learn.report import report_text
from grammarlab.runs.sample.domains import DOMAINS, domain_of, suffix_of
from grammarlab.runs.sample.shipped import find_rules
from grammarlab.runs.work import workers
from tests.cases import takes_turns
from tests.command_line import invoke
from tests.pages.scoring.windows import Window, shown_models
from tests.runs.boxes import BOXES, NAMES, begin

TEXT = '{"ranges": {"width": [1, 4], "height": [2, 10], "depth": [1, 4]}}'
SEED, SIZE = 3, 400


@pytest.fixture
def boxes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file of boxes, a kind that this process and its workers know."""
    monkeypatch.setitem(DOMAINS, ".boxes", BOXES)
    monkeypatch.setattr(workers, "_begin", begin)
    file = tmp_path / "my.boxes"
    file.write_text(TEXT)
    return file


@pytest.fixture
def run() -> Callable[..., Any]:
    def call(*arguments: object, code: int = 0) -> Any:
        result = invoke(*arguments)
        assert result.exit_code == code, result.output
        return result

    return call


def space_of(file: Path) -> Any:
    return domain_of(".boxes").open(file.read_text(), file.stem, file.parent)


def liked(rows: np.ndarray) -> np.ndarray:
    """[n] scores of boxes: tall and narrow ones."""
    return np.clip(25.0 * (rows[:, 1] - 6.0), 0.0, 100.0) * (rows[:, 0] < 2.5)


def extents(folder: Path) -> np.ndarray:
    """[n, 3] sizes of the models of a run, from their files."""
    return np.array([trimesh.load_scene(path).extents for path in sorted(folder.glob("*.glb"))])


def test_a_suffix_is_known_while_its_domain_is_listed(boxes: Path):
    assert suffix_of(boxes) == ".boxes"
    assert suffix_of(Path("rules.txt")) == suffix_of(Path("house.cga")) == ".cga"
    assert find_rules(str(boxes)).file == "my.boxes"
    with pytest.raises(
        UsageError, match=r"files that end in '\.spheres' cannot be read; expected one of \.boxes, \.cga, \.toml, \.xml"
    ):
        domain_of(".spheres")


@takes_turns
def test_boxes_are_sampled_in_any_number_of_processes(boxes: Path, run: Callable[..., Any], tmp_path: Path):
    command = ["sample", boxes, "-n", 66, "--seed", 5, "--no-image"]
    told = json.loads(run(*command, "--jobs", 2, "-o", tmp_path / "a", "--json").stdout)
    rows = space_of(boxes).make([Address(False, 5, model) for model in range(66)])
    assert extents(tmp_path / "a") == pytest.approx(rows, abs=1e-5)
    assert [(model["index"], model["shapes"], model["triangles"]) for model in told["models"]] == [
        (index, 1, 12) for index in range(66)
    ]
    repeated = run("sample", "--manifest", tmp_path / "a", "-o", tmp_path / "b", "--jobs", 1)
    assert "bit for bit" in repeated.output
    run(*command, "--jobs", 1, "-o", tmp_path / "c", "--single-file")
    assert len(trimesh.load_scene(tmp_path / "c" / "my.glb").graph.nodes_geometry) == 66
    run(*command[:-1], "--no-models", "--jobs", 1, "-o", tmp_path / "rows")
    table = parquet.read_table(tmp_path / "rows" / "shards")
    assert np.array_equal(np.column_stack([table[name] for name in NAMES]), rows)


def test_an_interrupted_run_goes_on(boxes: Path, run: Callable[..., Any], tmp_path: Path):
    command = ["sample", boxes, "-n", 3, "--jobs", 1, "-o", tmp_path / "a"]
    run(*command)
    before = {path.name: path.read_bytes() for path in (tmp_path / "a").glob("my*")}
    (tmp_path / "a" / "my-00001.glb").unlink()
    (tmp_path / "a" / "my.png").unlink()
    run(*command, "--resume")
    assert {path.name: path.read_bytes() for path in (tmp_path / "a").glob("my*")} == before


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--attr", "width=3"], "no attributes"),
        (["--start", "Lot"], "no start rule"),
        (["--footprint", "20x12"], "no footprint"),
    ],
)
def test_options_that_boxes_have_not_are_refused(
    boxes: Path, run: Callable[..., Any], options: list[str], message: str
):
    assert message in run("sample", boxes, *options, "-o", boxes.parent / "out", code=2).output
    assert not (boxes.parent / "out").exists()


def test_errors_are_told_as_those_of_rules(boxes: Path, run: Callable[..., Any]):
    boxes.write_text('{"ranges": {}}')
    assert "my.boxes:1:1: error: these are no boxes" in run("sample", boxes, "--jobs", 1, code=1).output
    with pytest.raises(GrammarlabError, match="these are no boxes"):
        Session(str(boxes), boxes.with_suffix(".db"), jobs=1)


def test_the_report_shows_boxes_before_and_after(boxes: Path, tmp_path: Path):
    space, pool = space_of(boxes), list(Pool(SEED, SIZE))[:40]
    scores = liked(space.make(pool)).tolist()
    rows = [address.label(OVERALL, score, space.hashes) for address, score in zip(pool, scores, strict=True)]
    given = str(boxes), Labels(tuple(rows)), tmp_path / "new.boxes"
    result = learn_from_labels(*given, Making(base="uniform"), labels_from="labels.csv", pool=Pool(SEED, SIZE))
    page = page_of_labels(result)
    assert "from my.boxes and labels.csv" in report_text(page)
    before, after = (liked(density.scene(200, 1).size).mean() for density in (page.before, page.after))
    assert after > 2.0 * before
    with pytest.raises(UsageError, match="unknown method 'compile'; expected one of cells"):
        learn_from_labels(*given, Making("compile"), labels_from="labels.csv")


@takes_turns
def test_what_is_learned_about_boxes_is_sampled_and_learned_from_again(
    boxes: Path, run: Callable[..., Any], tmp_path: Path
):
    def taught(file: Path) -> Path:
        """Learns from scores of the models of a file."""
        space, pool = space_of(file), list(Pool(SEED))[:160]
        scores = liked(space.make(pool)).tolist()
        rows = [address.label(OVERALL, score, space.hashes) for address, score in zip(pool, scores, strict=True)]
        labels, learned = tmp_path / f"{file.stem}.csv", tmp_path / f"{file.stem}-liked.boxes"
        save_labels(Labels(tuple(rows)), labels)
        command = ["learn", file, "--labels", labels, "--seed", SEED, "-o", learned, "--json"]
        found = json.loads(run(*command).stdout)
        assert found["js"] < min(0.05, found["js_before"])
        assert found["rules_after"] == 512
        assert set(found["features"]) == {"width", "height", "depth"}
        return learned

    once = taught(boxes)
    twice = taught(once)
    assert "my.boxes" in json.loads(once.read_text())["about"][0]
    for file, seed in ((boxes, 1), (once, 2), (twice, 3)):
        run("sample", file, "-n", 256, "--seed", seed, "-o", tmp_path / f"out-{file.stem}", "--no-image", "--jobs", 1)
    means = [liked(extents(tmp_path / f"out-{file.stem}")).mean() for file in (boxes, once, twice)]
    assert means[0] < 25.0
    assert 55.0 < means[1] < means[2]


@takes_turns
def test_the_page_scores_draws_and_learns_boxes(boxes: Path, run: Callable[..., Any], tmp_path: Path):
    file = tmp_path / "scores.db"
    with closing(Session(str(boxes), file, seed=SEED, size=SIZE, jobs=1)) as session:
        window, space = Window(session), space_of(boxes)
        state = session.call("state")[0]
        assert state["title"] == "my"
        models = shown_models(state)
        window.ask({"id": "p", "command": "pictures", "models": models[:2], "size": 64})
        _, pictures = window.wait(lambda message: message.get("event") == "pictures")
        assert len(pictures[0]) > 0
        answer, (glb,) = session.call("model", model=models[0])
        assert answer["label"].startswith("model ")
        (tmp_path / "one.glb").write_bytes(glb)
        row = space.make([Address.parse(models[0])])
        assert trimesh.load_scene(tmp_path / "one.glb").extents == pytest.approx(row[0], abs=1e-5)
        for model, score in zip(models, liked(space.make(list(map(Address.parse, models)))).tolist(), strict=True):
            session.call("score", models=[model], score=score)
        window.forget()
        session.call("update")
        window.state(lambda state: state["updating"] is None and shown_models(state) != models)
        state = session.call("state")[0]
        assert {entry["name"] for entry in state["relevance"]} <= {"width", "height", "depth"}
        _, (exported,) = session.call("export", format="csv")
        learned, _ = session.call("learn")
        assert learned["file"] == "scores-learned.boxes"
        assert (tmp_path / learned["file"]).read_text() == learned["text"]
        _, (sheet,) = session.call("sheet", num=4)
        assert sheet[:4] == b"\x89PNG"
    (tmp_path / "exported.csv").write_bytes(exported)
    assert {label.grammar for label in read_labels(tmp_path / "exported.csv")} <= set(space.hashes)
    # The session file says what it is about, and the command line learns the same from it.
    with closing(Store.open(file)) as store:
        assert (store.about.suffix, store.about.grammar) == (".boxes", TEXT)
    run("learn", boxes, "--labels", file, "-o", tmp_path / "again.boxes")
    texts = json.loads(learned["text"]), json.loads((tmp_path / "again.boxes").read_text())
    assert texts[0]["weights"] == texts[1]["weights"]
    (tmp_path / "same.cga").write_text(TEXT)
    with pytest.raises(UsageError, match="about another grammar"):
        Session(str(tmp_path / "same.cga"), file, jobs=0)


def test_a_session_about_an_unknown_kind_says_so(boxes: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    Session(str(boxes), tmp_path / "scores.db", jobs=0).close()
    monkeypatch.undo()
    for stored in (False, True):
        with pytest.raises(UsageError, match=r"files that end in '\.boxes' cannot be read"):
            Session(str(boxes), tmp_path / "scores.db", jobs=0, stored_grammar=stored)
