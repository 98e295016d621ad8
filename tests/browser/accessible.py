"""What axe-core finds on a page as it is: whatever it calls serious or critical fails a test."""

from __future__ import annotations

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page

from tests.browser.driver import settle

IMPACTS = {"serious", "critical"}


def expect_accessible(page: Page) -> None:
    """Nobody who reads with ears, or moves with keys, is kept out by what the page shows now."""
    settle(page)  # half a colour has half a contrast
    found = Axe().run(page).response["violations"]
    assert [
        (rule["id"], rule["help"], [(node["target"], node["failureSummary"]) for node in rule["nodes"]])
        for rule in found
        if rule["impact"] in IMPACTS
    ] == []
