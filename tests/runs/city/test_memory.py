"""What stays in memory of a map grows by little with every parcel."""

from __future__ import annotations

import gc
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import pytest
import shapely

from grammarlab.city.plan import read_plan
from grammarlab.runs.city.survey import Survey, surveyed
from grammarlab.runs.city.zone_rules import ZoneRules
from tests.cases import takes_turns
from tests.runs.city.plans import write_plan


def survey_of(folder: Path, num: int) -> Survey:
    """Parcels of four corners in rows, with ids of eight characters."""
    west, south = ([step * (row % 50 if step < 30 else row // 50) for row in range(num)] for step in (20, 30))
    corners = zip(west, south, strict=True)
    boxes = {f"west{row:04d}": shapely.box(x, y, x + 20, y + 30) for row, (x, y) in enumerate(corners)}
    plan = read_plan(write_plan(folder, boxes))
    return surveyed(plan, [ZoneRules.of(zone) for zone in plan.zones])


def bytes_of(folder: Path, num: int, kept: Callable[[Survey], Survey]) -> int:
    """What is allocated while the parts of a survey exist that are kept."""
    tracemalloc.start()
    survey = kept(survey_of(folder, num))
    gc.collect()
    size, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(survey.parcels) == num
    return size


@takes_turns
@pytest.mark.parametrize(
    ("kept", "most"),
    [(lambda survey: survey, 480), (lambda survey: survey.without_buildings([False, False]), 220)],
    ids=["all", "while buildings are derived"],
)
def test_a_survey_takes_little_memory_per_parcel(tmp_path: Path, kept: Callable[[Survey], Survey], most: float):
    """A polygon of shapely alone takes 64 bytes that are traced, and hundreds for its corners."""
    survey_of(tmp_path / "warm", 8)
    growth = bytes_of(tmp_path / "many", 4000, kept) - bytes_of(tmp_path / "few", 2000, kept)
    assert 0 < growth / 2000 < most
