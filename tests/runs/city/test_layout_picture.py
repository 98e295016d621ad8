from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image

from grammarlab.city.city_layout import laid_out
from grammarlab.city.layout_request import LayoutRequest
from grammarlab.runs.city.layout_picture import _LOT, _PARK, write_layout_picture


def test_parks_and_lots_cover_the_picture_as_they_cover_the_ground(tmp_path: Path):
    layout = laid_out(LayoutRequest(outline=shapely.box(0, 0, 420, 300), park_share=0.2, seed=5))
    write_layout_picture(layout, tmp_path / "plan.png")
    picture = np.asarray(Image.open(tmp_path / "plan.png"))
    ratio = (picture == _PARK).all(axis=2).sum() / (picture == _LOT).all(axis=2).sum()
    use = np.array(layout.parcels.attributes["use"].to_pylist())
    park, lots = (layout.parcels.area[use == kind].sum() for kind in ("park", "lots"))
    assert park > 0
    assert ratio == pytest.approx(park / lots, rel=0.2)
