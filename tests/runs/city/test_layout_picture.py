import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from grammarlab.errors import UsageError
from grammarlab.runs.city.layout_picture import _LOT, _PARK, write_layout

PLAN = """
[layout]
size = "420x300"
park_share = 0.2
seed = 5
[[zones]]
name = "all"
grammar = "building"
"""


def test_a_layout_is_written_as_maps_and_a_picture(tmp_path: Path):
    (tmp_path / "plan.toml").write_text(PLAN, encoding="utf-8")
    names = ("parcels.geojson", "streets.geojson", "plan.png")
    files = {name: tmp_path / name for name in names}
    layout = write_layout(tmp_path / "plan.toml", files[names[0]], streets=files[names[1]], picture=files[names[2]])
    features = [json.loads(files[name].read_text(encoding="utf-8"))["features"] for name in names[:2]]
    assert [len(part) for part in features] == [len(layout.parcels), len(layout.streets)]
    picture = np.asarray(Image.open(files["plan.png"]))
    ratio = (picture == _PARK).all(axis=2).sum() / (picture == _LOT).all(axis=2).sum()
    use = np.array(layout.parcels.attributes["use"].to_pylist())
    areas = [layout.parcels.area[use == kind].sum() for kind in ("park", "lots")]
    assert ratio == pytest.approx(areas[0] / areas[1], rel=0.2)


def test_a_plan_without_a_layout_is_refused(tmp_path: Path):
    text = PLAN[PLAN.index("[[zones]]") :]
    (tmp_path / "plan.toml").write_text(f'parcels = "map.geojson"\n{text}', encoding="utf-8")
    with pytest.raises(UsageError, match=r"expected a table \[layout\]"):
        write_layout(tmp_path / "plan.toml", tmp_path / "parcels.geojson")
