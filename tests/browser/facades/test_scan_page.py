"""The page of a scan: fits over points, and corrections that bind the next match and are saved."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from grammarlab.matching.corrections import Correction, load_corrections
from grammarlab.matching.library import templates_by_name
from grammarlab.matching.scenes import SceneOptions, rectangles
from grammarlab.pages.matcher import PAGE, Matcher
from grammarlab.pages.scan_desk import ScanDesk
from tests.browser.accessible import expect_accessible
from tests.browser.in_process import PageThread
from tests.cases import takes_turns


@pytest.fixture
def target(tmp_path: Path) -> Path:
    return tmp_path / "said.json"


@pytest.fixture
def page(windows: Any, target: Path) -> Iterator[Page]:
    elements = rectangles(SceneOptions(elements=4, kinds=2, noise=0.005, occluded=0.0), 2)
    server = PageThread(Matcher(ScanDesk("scene.json", elements, templates_by_name("rectangle"), target)), PAGE)
    yield windows(server.address)
    server.close()


@takes_turns
def test_what_a_person_says_is_saved_and_matched_again(page: Page, target: Path):
    settled = page.get_by_text(f"saved in {target}")
    box = [page.get_by_role("button", name=re.compile(rf"^element {each}:")) for each in range(4)]
    expect(settled).to_be_visible()
    expect(box[0]).to_have_attribute("aria-label", re.compile(r"rectangle \d: width"))
    assert len({page.locator(".sc-fit").nth(each).get_attribute("stroke") for each in range(4)}) == 2
    page.get_by_role("button", name="Ignore").click()
    expect(page.get_by_role("alert").filter(has_text="Choose elements first")).to_be_visible()
    box[3].click()
    page.get_by_role("button", name="Ignore").click()
    expect(box[3]).to_have_attribute("aria-label", re.compile("left out by a correction"))
    expect(settled).to_be_visible()
    expect_accessible(page)
    page.get_by_role("button", name="None", exact=True).click()
    box[0].focus()
    page.keyboard.press("Enter")
    box[1].click()
    page.get_by_label("width in metres").fill("1.25")
    page.get_by_role("button", name="Share width").click()
    expect(box[0]).to_have_attribute("aria-label", re.compile("width 1.2[45]"))
    expect(settled).to_be_visible()
    said = (Correction("ignore", (3,)), Correction("share", (0, 1), "width", 1.25))
    assert load_corrections(target) == said
    page.get_by_role("button", name="Take back").first.click()
    expect(page.get_by_role("list", name="Corrections").get_by_role("listitem")).to_have_count(1)
    expect(box[3]).to_have_attribute("aria-label", re.compile("rectangle"))
    assert load_corrections(target) == said[1:]
    page.get_by_role("button", name="Undo").click()
    expect(page.get_by_role("list", name="Corrections").get_by_role("listitem")).to_have_count(2)
    assert load_corrections(target) == said
