"""The page of runs: models turn, trees are walked, two runs stand side by side, and one file has all of it."""

from __future__ import annotations

import json
import os
import re
import shlex
from pathlib import Path
from shutil import copytree
from typing import Any

import pytest
from playwright.sync_api import expect

from grammarlab.errors import AssetError
from grammarlab.pages.run_page import RunPage, run_page
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.run import sample_run
from tests.browser.accessible import expect_accessible

RULES = """
Lot --> extrude(rand(6, 9)) report("</script>", scope.sy) comp(f) { top : Roof | side : Facade }
Facade --> split(x) { ~1 : Wall | 2 : color("#a0c4d8") Window | ~1 : Wall }
"""


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folders = [tmp_path_factory.mktemp("runs") / name for name in ("one", "other")]
    for seed, folder in enumerate(folders):
        request = SampleRequest(name="house", text=RULES, assets=Path(), num_models=3, seed=seed, image=False)
        sample_run(request, folder)
    return folders


def test_two_runs_are_walked_with_mouse_and_keys(windows: Any, runs: list[Path], tmp_path: Path):
    file = tmp_path / "runs.html"
    file.write_text(run_page(runs).content, encoding="utf-8")
    page = windows(file.as_uri(), size=(1000, 640), reduced_motion="reduce")
    first, second = page.locator("canvas").all()
    expect(second).to_have_attribute("data-shown", "0")
    before = first.screenshot(), second.screenshot()
    # Both turn when one is turned.
    first.focus()
    page.keyboard.press("Shift+ArrowLeft")
    expect_change(first, before[0])
    expect_change(second, before[1])
    # A row of the tree colours the shapes of its symbol; keys open and close it.
    tree = page.get_by_role("tree").first
    before = first.screenshot(), second.screenshot()
    tree.get_by_role("treeitem").filter(has_text="Window").first.click()
    expect(page.get_by_role("status").filter(has_text="Window: shown in green")).to_have_count(1)
    expect_change(first, before[0])
    expect_accessible(page)
    page.keyboard.press("ArrowLeft")
    expect(tree.locator("[aria-selected=true]")).to_contain_text("Facade")
    page.keyboard.press("ArrowLeft")
    expect(tree.locator("[aria-selected=true]")).to_have_attribute("aria-expanded", "false")
    # A click on a part finds its row.
    box = first.bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    expect(tree.locator("[aria-selected=true]")).to_contain_text("Roof")
    # Examples are marked by key and by mouse, each run has its own.
    first.focus()
    page.keyboard.press("m")
    notes = page.locator("[aria-live=polite]")
    expect(notes).to_contain_text("house, seed 0, model 0: a good example")
    page.keyboard.press("n")
    expect(second).to_have_attribute("data-shown", "1")
    mark, options = (
        page.get_by_role("checkbox", name="a good example of house, seed"),
        page.get_by_label("Options of grammarlab learn for the examples of house, seed 0"),
    )
    expect(mark.first).not_to_be_checked()
    mark.first.check()
    expect(options).to_have_value(f"--examples {shlex.quote(runs[0].as_posix())} --models 0-1")
    expect(mark.last).not_to_be_checked()
    expect(page.get_by_role("checkbox", name="a good example of house, seed 1")).to_have_count(1)
    expect_accessible(page)
    page.keyboard.press("m")
    expect(options).to_have_value(f"--examples {shlex.quote(runs[0].as_posix())} --models 0")
    expect(notes).to_contain_text("house, seed 0, model 1: no longer a good example")
    page.get_by_role("combobox", name="Model").select_option("2")
    expect(first).to_have_attribute("data-shown", "2")
    expect(page.get_by_text("</script>").first).to_be_visible()
    page.keyboard.press("t")
    expect(page.get_by_role("button", name="Turn")).to_have_attribute("aria-pressed", "true")
    page.set_viewport_size({"width": 400, "height": 700})
    assert page.evaluate("document.documentElement.scrollWidth") <= 400


def test_runs_of_one_name_have_names_of_their_own(runs: list[Path], tmp_path: Path):
    a, b, c = (copytree(runs[0], tmp_path / name / "run") for name in "abc")
    c = c.rename(c.with_name("walk"))
    assert names_of(run_page([a, b])) == ["house, seed 0, in a/run", "house, seed 0, in b/run"]
    assert names_of(run_page([a, c])) == ["house, seed 0, in run", "house, seed 0, in walk"]
    # Paths are not sent.
    for page in (run_page([a, b], sent=True), run_page([a, a])):
        assert names_of(page) == ["house, seed 0, in run (1)", "house, seed 0, in run (2)"]


def names_of(page: RunPage) -> list[str]:
    data = re.search(r'<script type="application/json" id="runs">(.*?)</script>', page.content, re.DOTALL)
    assert data
    return [run["name"] for run in json.loads(data[1])]


def test_a_page_has_a_largest_size_and_says_what_is_left_out(runs: list[Path]):
    whole = run_page(runs[:1])
    assert whole.left_out == (0,)
    assert whole.content.count("</script>") == 2
    assert run_page(runs[:1], 3500).left_out in ((1,), (2,))
    with pytest.raises(AssetError, match="no finished model"):
        run_page(runs[:1], 10)


def expect_change(canvas: Any, before: bytes) -> None:
    for _ in range(50):
        if canvas.screenshot() != before:
            return
        canvas.page.wait_for_timeout(50)
    raise AssertionError("the picture has not changed")


def test_offered_options_lead_to_the_run(runs: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    run = copytree(runs[0], tmp_path / "out" / "my run; $HOME")
    places = {
        tmp_path: Path("out", run.name),
        run: Path(),
        run.parent: run,
        runs[0]: Path(os.path.relpath(run, runs[0])),
    }
    for place, folder in places.items():
        monkeypatch.chdir(place)
        (argument,) = shlex.split(offered(run_page([folder]).content))
        assert Path(argument).samefile(run)
        # A page that is sent has no paths of whoever made it.
        assert shlex.split(offered(run_page([folder], sent=True).content)) == [run.name]


def offered(content: str) -> str:
    """The folder in the data of a page, as a text for a shell."""
    data = content.split('id="runs">')[1].split("</script>", maxsplit=1)[0]
    return json.loads(data)[0]["folder"]


def test_runs_of_one_name_are_told_apart_by_their_folders(runs: list[Path], tmp_path: Path):
    again = tmp_path / "again"
    copytree(runs[0], again)
    assert "<title>house, seed 0, in one and house, seed 0, in again" in run_page([runs[0], again]).content
    assert "<title>house, seed 0 and house, seed 1" in run_page(runs).content
