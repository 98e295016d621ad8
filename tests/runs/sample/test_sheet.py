"""Contact sheets: every model once, the same page whoever draws it, and who drew it in the manifest."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from grammarlab.errors import UsageError
from grammarlab.rendering.choice import RendererChoice, choose
from grammarlab.runs.sample import contact_sheet
from grammarlab.runs.sample import run as sample_module
from grammarlab.runs.sample import run as sheet_module
from grammarlab.runs.sample.contact_sheet import BORDER, PAPER, draw_page, lay_out
from grammarlab.runs.sample.manifest import read_manifest
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.run import repeat_run, sample_run
from grammarlab.runs.work.executor_choice import executor_of
from grammarlab.runs.work.executors import Processes
from tests.cases import takes_turns
from tests.runs.grammars import TOWER


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    monkeypatch.setattr(sheet_module, "TILE_AREA", 40 * 40)


def request(tmp_path, **options: Any):
    values: dict[str, Any] = {"num_models": 3, **options}
    return SampleRequest(name="tower", text=TOWER, assets=tmp_path, **values)


def read(path):
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(int)


@given(st.integers(1, 200), st.integers(0, 30), st.integers(20, 400), st.integers(20, 400))
def test_pictures_lie_side_by_side_on_the_page_without_touching(num, columns, width, height):
    page = lay_out(num, columns, width, height)
    assert page.columns == min(columns, num) or columns == 0
    assert (page.rows - 1) * page.columns < num <= page.rows * page.columns
    places = np.array([page.corner(index) for index in range(num)])
    assert (places >= BORDER).all()
    assert (places + np.array([width, height]) <= np.array(page.size()) - BORDER).all()
    ordered = sorted(map(tuple, places.tolist()))
    for one, other in pairwise(ordered):
        assert other[0] >= one[0] + width or other[1] >= one[1] + height


@pytest.mark.parametrize(("num", "columns"), [(1, 1), (4, 2), (9, 3), (16, 4), (144, 12)])
def test_squares_fill_a_square_page(num, columns):
    assert lay_out(num, 0, 320, 320).columns == columns


def test_the_page_shows_every_picture_where_it_belongs():
    page = lay_out(5, 2, 30, 20)
    pictures = [np.full((20, 30, 3), 40 * index, np.uint8) for index in range(5)]
    sheet = draw_page(page, pictures, [(str(i), "1 x 1 x 1 m") for i in range(5)], ("name", "a long remark " * 9))
    for index in range(5):
        left, top = page.corner(index)
        assert (sheet[top : top + 20, left : left + 30] == 40 * index).all()
    left, top = page.corner(5)
    assert (sheet[top : top + 20, left : left + 30] == PAPER).all()


def test_the_sheet_has_a_picture_and_a_caption_for_each_model(tmp_path):
    result = sample_run(request(tmp_path, num_models=5, columns=2), tmp_path / "out")
    assert result.sheet is not None
    sheet = read(result.sheet)
    width, height = 10, 10
    while lay_out(5, 2, width, height).size()[0] < sheet.shape[1]:
        width += 1
    while lay_out(5, 2, width, height).size()[1] < sheet.shape[0]:
        height += 1
    page = lay_out(5, 2, width, height)
    for index in range(5):
        left, top = page.corner(index)
        assert sheet[top : top + height, left : left + width].std() > 3
        assert sheet[top + height : top + height + 24, left : left + width].min() < 100
    left, top = page.corner(5)
    assert (sheet[top : top + height + 24, left : left + width] == PAPER).all()


def test_the_sheet_does_not_depend_on_the_number_of_processes(tmp_path):
    sheets = [sample_run(request(tmp_path), tmp_path / str(jobs), executor=executor_of(jobs)).sheet for jobs in (1, 2)]
    assert sheets[0] is not None
    assert sheets[1] is not None
    assert sheets[0].read_bytes() == sheets[1].read_bytes()


def test_pictures_take_the_shape_of_the_models(tmp_path):
    shapes = {}
    for name, text in {"tall": "Lot --> s(1, 0, 1) extrude(9) A.", "wide": "Lot --> s(9, 0, 2) extrude(1) A."}.items():
        made = SampleRequest(name=name, text=text, assets=tmp_path, num_models=1)
        sheet = sample_run(made, tmp_path / name).sheet
        assert sheet is not None
        shapes[name] = read(sheet).shape
    assert shapes["tall"][0] > shapes["wide"][0]
    assert shapes["tall"][1] < shapes["wide"][1]


def test_at_one_scale_a_small_model_is_small_and_alone_it_fills_its_picture(tmp_path):
    text = "attr big = 50% : 1 else : 0\nLot --> s(2 + 20 * big, 0, 2 + 20 * big) extrude(2 + 20 * big) A."
    covered = {}
    for scale in ("same", "each"):
        made = SampleRequest(name="box", text=text, assets=tmp_path, num_models=6, seed=3, scale=scale, columns=6)
        sheet = sample_run(made, tmp_path / scale).sheet
        assert sheet is not None
        image = read(sheet)
        width = (image.shape[1] - 2 * BORDER - 50) // 6
        tiles = [image[60:-45, BORDER + k * (width + 10) :][:, : width - 2] for k in range(6)]
        covered[scale] = [(np.abs(t - t[:, :1]).max(axis=2) > 24).mean() for t in tiles]
    assert min(covered["same"]) < 0.3 * max(covered["same"])
    assert min(covered["each"]) > 0.8 * max(covered["each"])


def test_models_without_shapes_have_an_empty_picture(tmp_path):
    made = SampleRequest(name="nothing", text="Lot --> NIL", assets=tmp_path, num_models=2)
    sheet = sample_run(made, tmp_path / "out").sheet
    assert sheet is not None
    assert read(sheet).shape[2] == 3


def test_ctrl_c_while_drawing_leaves_no_half_picture_and_the_run_goes_on_later(tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(contact_sheet, "_draw", interrupted)
        with pytest.raises(KeyboardInterrupt):
            sample_run(request(tmp_path), tmp_path / "out")
    names = {p.name for p in (tmp_path / "out").iterdir()}
    assert "tower-00002.glb" in names
    assert not [n for n in names if n.startswith("tower.png")]
    assert not read_manifest(tmp_path / "out").complete
    result = sample_run(request(tmp_path), tmp_path / "out", resume=True)
    assert result.sheet is not None
    assert result.sheet.is_file()


def test_the_manifest_says_which_renderer_really_drew(tmp_path, monkeypatch):
    monkeypatch.setattr(sample_module, "choose", lambda _name: RendererChoice("cast"))
    result = sample_run(request(tmp_path, renderer="auto"), tmp_path / "out")
    manifest = read_manifest(result.manifest)
    assert result.request.renderer == manifest.request.renderer == "cast"
    assert "opengl" not in manifest.versions
    assert sample_run(request(tmp_path, renderer="auto"), tmp_path / "out", resume=True).request == result.request


def test_without_opengl_a_picture_by_opengl_is_refused_before_anything_is_written(tmp_path, monkeypatch):
    def refuse(_name):
        raise UsageError("OpenGL does not work here")

    monkeypatch.setattr(sample_module, "choose", refuse)
    with pytest.raises(UsageError, match="OpenGL does not work here"):
        sample_run(request(tmp_path, renderer="gl"), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_without_a_picture_no_renderer_is_looked_for(tmp_path, monkeypatch):
    monkeypatch.setattr(sample_module, "choose", None)
    result = sample_run(request(tmp_path, renderer="auto", image=False), tmp_path / "out")
    assert (result.sheet, result.request.renderer) == (None, "auto")


@takes_turns
def test_a_picture_by_opengl_is_recorded_with_its_driver_and_repeated(tmp_path):
    found = choose("auto")
    if found.name != "gl":
        pytest.skip("OpenGL does not work on this machine")
    first = sample_run(request(tmp_path, renderer="auto"), tmp_path / "first", executor=Processes(2))
    manifest = read_manifest(first.manifest)
    assert manifest.request.renderer == "gl"
    assert manifest.versions["opengl"] == found.driver
    assert repeat_run(manifest, tmp_path / "second")[1] == ()
