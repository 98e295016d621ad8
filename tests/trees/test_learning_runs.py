"""What is liked about trees, learned from files, at the page, and from Python, like that about models of grammars."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import grammarlab as gl
from grammarlab.arrays import Floats
from grammarlab.errors import UsageError
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.pool import Pool
from grammarlab.pages.record.store import Store
from grammarlab.pages.scoring.session import Session
from grammarlab.preference.label_files import read_labels, save_labels
from grammarlab.preference.labels import OVERALL
from grammarlab.runs.learn.density_pages import page_of_examples, page_of_labels
from grammarlab.runs.learn.from_examples import learn_from_files
from grammarlab.runs.learn.from_labels import learn_from_labels
from grammarlab.runs.learn.report import report_text
from grammarlab.runs.sample.domains import domain_of
from grammarlab.trees.parameters import COLUMN
from grammarlab.trees.species_file import parse
from tests.cases import takes_turns
from tests.command_line import invoke
from tests.pages.scoring.windows import Window, shown_models
from tests.trees.small_species import SMALL

SEED, SIZE = 3, 300
HEAD = "# Learned by grammarlab "
LEARNED = {
    *(
        "labels",
        "method",
        "js",
        "js_before",
        "taught",
        "steps",
        "features",
        "kept",
        "knowledge",
        "likes",
        "dislikes",
        "expected_gain",
        "explained",
    ),
    *("effective_models", "acceptance", "rules_before", "rules_after", "seconds", "notes", "findings"),
}
"""Members of the object of ``grammarlab learn --labels --json`` about a grammar."""


@pytest.fixture
def species(tmp_path: Path) -> Path:
    file = tmp_path / "small.toml"
    file.write_text(SMALL)
    return file


@pytest.fixture
def run() -> Callable[..., Any]:
    def call(*arguments: object, code: int = 0) -> Any:
        result = invoke(*arguments)
        assert result.exit_code == code, result.output
        assert "Traceback" not in result.output
        return result

    return call


def liked(rows: Floats) -> Floats:
    """[n] scores of trees: tall and slender ones."""
    return np.where((rows[:, COLUMN["scale"]] > 5.5) & (rows[:, COLUMN["ratio"]] < 0.02), 100.0, 0.0)


def space_of(file: Path) -> Any:
    return domain_of(".toml").open(file.read_text(), file.stem, file.parent)


def labels_of(file: Path, num: int) -> gl.Labels:
    """Scores of the first trees of the pool."""
    space, pool = space_of(file), list(Pool(SEED, SIZE))[:num]
    scores = liked(space.make(pool).rows).tolist()
    return gl.Labels(
        tuple(address.label(OVERALL, score, space.hashes) for address, score in zip(pool, scores, strict=True))
    )


def share_liked(file: Path) -> float:
    """Mean score of the trees of a file, of 1."""
    return float(liked(space_of(file).make([Address(False, 9, model) for model in range(200)]).rows).mean()) / 100.0


@takes_turns
def test_labels_teach_a_species_that_a_person_can_read(species: Path, run: Callable[..., Any], tmp_path: Path):
    save_labels(labels_of(species, 120), tmp_path / "labels.csv")
    learned = tmp_path / "liked.toml"
    found = json.loads(
        run("learn", species, "--labels", tmp_path / "labels.csv", "--seed", SEED, "-o", learned, "--json").stdout
    )
    assert found.keys() - {"accept_rate"} == LEARNED
    assert found["js"] < found["js_before"] / 3.0
    assert share_liked(species) < 0.4
    assert share_liked(learned) > 0.85
    text = learned.read_text()
    assert text.startswith(HEAD)
    assert "from small.toml" in text.splitlines()[0]
    assert "scale" in text.partition("[[kinds]]")[2] or "scale" in parse(text, "liked").acceptance
    # The new file is sampled, checked, compared and learned from like any other.
    run("sample", learned, "-n", 2, "--no-image", "--jobs", 1, "-o", tmp_path / "out")
    run("check", learned)
    compared = json.loads(run("compare", species, learned, "--json").stdout)
    assert compared["js"] > 0.2
    assert {"scale", "ratio"} <= {number["attribute"] for number in compared["numbers"]}
    assert run("format", learned).stdout.startswith(text.partition("\n\n")[0])


def test_the_report_shows_trees_before_and_after(species: Path, tmp_path: Path):
    labels = labels_of(species, 80)
    result = learn_from_labels(
        str(species), labels, tmp_path / "new.toml", labels_from="labels.csv", pool=Pool(SEED, SIZE)
    )
    page = page_of_labels(result)
    assert "from small.toml and labels.csv" in report_text(page)
    assert "| kinds |" in report_text(page)
    assert [density.scene(2, 1).num_models for density in (page.before, page.after)] == [2, 2]


def test_labels_of_another_species_are_refused(species: Path, run: Callable[..., Any], tmp_path: Path):
    save_labels(labels_of(species, 20), tmp_path / "labels.csv")
    species.write_text(SMALL.replace("levels = 2", "levels = 3"))
    told = run("learn", species, "--labels", tmp_path / "labels.csv", "-o", tmp_path / "new.toml", code=2).stderr
    assert "score models of this one" in told
    assert not (tmp_path / "new.toml").exists()


@takes_turns
def test_a_function_teaches_a_species_from_columns_or_from_meshes():
    species = parse(SMALL, "small")
    pool = Pool(SEED, SIZE)
    found = gl.learn(species, lambda trees: trees.columns()["scale"] > 5.5, 48, pool=pool)
    assert isinstance(found, gl.LearnedDensity)
    trees = gl.sample(parse(found.learned.text, "small"), 100, seed=5)
    assert (trees.rows[:, COLUMN["scale"]] > 5.4).mean() > 0.9

    def tall(scene: gl.Scene) -> Floats:
        heights = np.full(scene.num_models, -np.inf)
        np.maximum.at(heights, scene.model, scene.position[:, 1] + scene.size[:, 1])
        return (heights > np.median(heights)).astype(np.float64)

    assert isinstance(gl.learn(species, tall, 16, sees="scene", pool=pool), gl.LearnedDensity)
    with pytest.raises(UsageError, match="sees: expected one of trees, scene, found 'forest'"):
        gl.learn(species, lambda trees: trees, 16, sees="forest")  # ty: ignore[no-matching-overload]  # pyright: ignore[reportCallIssue, reportArgumentType]
    with pytest.raises(UsageError, match="grammar: expected Grammar"):
        gl.learn("oak", lambda trees: trees, 16)  # ty: ignore[no-matching-overload]  # pyright: ignore[reportCallIssue, reportArgumentType]


@takes_turns
def test_the_page_scores_draws_and_learns_trees(species: Path, run: Callable[..., Any], tmp_path: Path):
    file = tmp_path / "scores.db"
    with closing(Session(str(species), file, seed=SEED, size=SIZE, jobs=1)) as session:
        window, space = Window(session), space_of(species)
        state = session.call("state")[0]
        assert state["title"] == "small"
        models = shown_models(state)
        window.ask({"id": "p", "command": "pictures", "models": models[:2], "size": 64})
        _, pictures = window.wait(lambda message: message.get("event") == "pictures")
        assert len(pictures[0]) > 0
        _, (glb,) = session.call("model", model=models[0])
        (tmp_path / "one.glb").write_bytes(glb)
        height = gl.measure_trees(gl.grow(*space.drawn([Address.parse(models[0])])))["height"][0]
        assert trimesh.load_scene(tmp_path / "one.glb").extents[1] == pytest.approx(height, rel=0.1)
        scores = liked(space.make(list(map(Address.parse, models))).rows).tolist()
        for model, score in zip(models, scores, strict=True):
            session.call("score", models=[model], score=score)
        window.forget()
        session.call("update")
        window.state(lambda state: state["updating"] is None and shown_models(state) != models)
        state = session.call("state")[0]
        if not any(scores):
            session.call("score", models=shown_models(state)[:1], score=100.0)
        _, (exported,) = session.call("export", format="csv")
        learned, _ = session.call("learn")
        assert learned["file"] == "scores-learned.toml"
        assert (tmp_path / learned["file"]).read_text() == learned["text"]
        _, (sheet,) = session.call("sheet", num=4)
        assert sheet[:4] == b"\x89PNG"
    (tmp_path / "exported.csv").write_bytes(exported)
    assert {label.grammar for label in read_labels(tmp_path / "exported.csv")} <= set(space.hashes)
    # The session file says what it is about, and the command line learns the same from it.
    with closing(Store.open(file)) as store:
        assert (store.about.suffix, store.about.grammar) == (".toml", SMALL)
    run("learn", species, "--labels", file, "-o", tmp_path / "again.toml")
    assert (tmp_path / "again.toml").read_text() == learned["text"]
    (tmp_path / "same.cga").write_text(SMALL)
    with pytest.raises(UsageError, match="about another grammar"):
        Session(str(tmp_path / "same.cga"), file, jobs=0)


@pytest.fixture
def examples(species: Path, run: Callable[..., Any], tmp_path: Path) -> Path:
    """A folder with trees that are either tall and slender, or small."""
    kinds = "".join(
        f"\n[[kinds]]\nweight = 0.5\n[kinds.ranges]\nscale = {scale}\nratio = {ratio}\n"
        for scale, ratio in (("[6.5, 8.0]", "[0.01, 0.015]"), ("[3.0, 3.5]", "[0.01, 0.03]"))
    )
    (tmp_path / "either.toml").write_text(SMALL + kinds)
    options = ("--no-image", "--jobs", 1, "--attr", "detail=low", "-o", tmp_path / "examples")
    run("sample", tmp_path / "either.toml", "-n", 80, *options)
    return tmp_path / "examples"


def test_examples_teach_the_kinds_of_trees_that_they_are(
    species: Path, examples: Path, run: Callable[..., Any], tmp_path: Path
):
    learned = tmp_path / "liked.toml"
    found = json.loads(run("learn", species, "--examples", examples, "-o", learned, "--json").stdout)
    assert found["examples"] == 80
    assert found["components"] == found["rules_after"] == 2
    assert found["held_out"]["examples"] == 16
    assert found["held_out"]["possible"] >= 14
    # Log-uniform parameters: the share of trees of the original that are like the examples, half of each kind.
    shares = [
        math.log(8.0 / 6.5) / math.log(8.0 / 3.0) * math.log(1.5) / math.log(3.0),
        math.log(3.5 / 3.0) / math.log(8.0 / 3.0),
    ]
    expected = float(np.mean([math.log(0.5 / share) for share in shares]))
    assert found["held_out"]["gain"] == pytest.approx(expected, abs=0.4)
    kinds = sorted(parse(learned.read_text(), "liked").kinds, key=lambda kind: kind.low[COLUMN["scale"]])
    assert kinds[0].high[COLUMN["scale"]] == pytest.approx(3.5, abs=0.1)
    assert kinds[1].low[COLUMN["scale"]] == pytest.approx(6.5, abs=0.1)
    assert kinds[1].high[COLUMN["ratio"]] == pytest.approx(0.015, abs=0.001)
    assert kinds[0].high[COLUMN["ratio"]] > 0.028
    assert sum(kind.weight for kind in kinds) == pytest.approx(1.0)


def test_objects_of_examples_are_those_of_grammars(
    species: Path, examples: Path, run: Callable[..., Any], tmp_path: Path
):
    run("sample", "toy", "-n", 60, "--no-image", "--jobs", 1, "-o", tmp_path / "toys")
    trees = json.loads(run("learn", species, "--examples", examples, "-o", tmp_path / "a.toml", "--json").stdout)
    toys = json.loads(run("learn", "toy", "--examples", tmp_path / "toys", "-o", tmp_path / "a.cga", "--json").stdout)
    assert trees.keys() == toys.keys()
    assert trees["held_out"].keys() == toys["held_out"].keys()
    assert "2 kinds, 1 before" in run("learn", species, "--examples", examples, "-o", tmp_path / "b.toml").stderr


def test_one_batch_or_its_file_are_examples_and_the_page_shows_them(species: Path, examples: Path, tmp_path: Path):
    table = examples / "derivations" / "00000" / "trees.parquet"
    results = [learn_from_files(str(species), path, tmp_path / "a.toml") for path in (table.parent, table)]
    assert [result.num_examples for result in results] == [64, 64]
    assert results[0].learned.text.splitlines()[3:] == results[1].learned.text.splitlines()[3:]
    page = page_of_examples(results[0])
    assert "| kinds | 1 | 2 |" in report_text(page)
    assert page.after.scene(2, 1).num_models == 2


def test_other_trees_and_other_files_are_no_examples(
    species: Path, examples: Path, run: Callable[..., Any], tmp_path: Path
):
    species.write_text(SMALL.replace("range = [3.0, 8.0]", "range = [4.0, 8.0]"))
    told = run("learn", species, "--examples", examples, "-o", tmp_path / "a.toml", code=2).stderr
    assert "examples are not trees of this species: scale is 3." in told
    assert "not within 4 to 8" in told
    assert "no examples at" in run("learn", species, "--examples", tmp_path / "no", code=2).stderr
    assert "found none" in run("learn", species, "--examples", tmp_path, code=2).stderr
    assert "expected a folder" in run("learn", species, "--examples", species, code=2).stderr
    assert "unknown method 'tied'" in run("learn", species, "--examples", examples, "--method", "tied", code=2).stderr


def test_examples_of_a_whole_species_teach_nothing(species: Path, run: Callable[..., Any], tmp_path: Path):
    options = ("--no-image", "--jobs", 1, "--attr", "detail=low", "-o", tmp_path / "all")
    run("sample", species, "-n", 80, "--seed", 4, *options)
    found = json.loads(
        run("learn", species, "--examples", tmp_path / "all", "-o", tmp_path / "a.toml", "--json").stdout
    )
    assert (found["js_before"], found["components"], found["held_out"]["gain"]) == (0.0, 1, 0.0)
