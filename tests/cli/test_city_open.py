"""``grammarlab city open``."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from tests.cli.test_open import started
from tests.pages.city.small_city import write_city
from tests.waiting import PATIENCE


@pytest.mark.parametrize("has_plan", [True, False])
def test_a_city_is_served_until_ctrl_c(tmp_path: Path, has_plan: bool):
    write_city(tmp_path / "city")
    if not has_plan:
        (tmp_path / "town.toml").unlink()
    with started("city", "--no-browser", cwd=tmp_path, command=("city", "open")) as process:
        assert process.stdout
        assert process.stdout.readline().startswith("http://127.0.0.1:")
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    assert ("pins.csv" in said) == has_plan
    assert "Traceback" not in said


def test_a_folder_without_a_city_is_refused_in_words(tmp_path: Path):
    (tmp_path / "city").mkdir()
    with started("city", "--no-browser", cwd=tmp_path, command=("city", "open")) as process:
        _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1
    assert "parcels.parquet is missing" in said
    assert "Traceback" not in said
