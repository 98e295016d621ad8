"""Factors, scores as files, and updates that are cancelled."""

from __future__ import annotations

import json
import re

from playwright.sync_api import expect


def test_an_update_can_be_cancelled_and_blocks_nothing(towers):
    towers.cell(0).click()
    towers.press("5", "6", "7")
    towers.expect_saved()
    towers.press("Control+Enter")
    towers.button("Cancel").click()
    expect(towers.page.locator(".gl-busy:visible")).to_have_count(0)
    expect(towers.page.get_by_text("the predictions do not know all of them yet")).to_be_visible()


def test_a_factor_is_created_renamed_and_deleted(towers):
    towers.cell(0).click()
    towers.press("9")
    towers.expect_saved()
    towers.button("New factor").click()
    name = '<b>"colour"</b>'
    towers.page.keyboard.type(name)
    towers.press("Enter")
    tab = towers.page.get_by_role("button", name=name)
    expect(tab).to_have_attribute("aria-pressed", "true")
    expect(towers.page.locator(".gl-score").first).to_have_text("")
    towers.cell(0).click()
    towers.press("2")
    towers.expect_saved()
    assert towers.scores()[0] == "20"
    towers.page.get_by_role("button", name="overall").click()
    expect(towers.page.locator(".gl-score").first).to_have_text("90")
    tab.click()
    expect(tab).to_have_attribute("aria-pressed", "true")
    towers.button("Rename or delete this factor").click()
    towers.page.get_by_label("Name of the factor").fill("colour")
    towers.press("Enter")
    expect(towers.page.get_by_role("button", name="colour")).to_be_visible()
    towers.page.get_by_role("button", name="product").click()
    expect(towers.page.get_by_role("button", name="product")).to_have_attribute("aria-pressed", "true")
    towers.page.get_by_role("button", name="colour").click()
    expect(towers.page.get_by_role("button", name="colour")).to_have_attribute("aria-pressed", "true")
    towers.button("Rename or delete this factor").click()
    towers.page.get_by_role("button", name="Delete “colour” and its 1 score").click()
    expect(towers.page.locator(".gl-tab")).to_have_count(1)
    expect(towers.page.locator(".gl-score").first).to_have_text("90")


def test_scores_go_out_as_a_file_and_come_back(towers, tmp_path):
    towers.cell(0).click()
    towers.press("1", "2", "3", "4")
    towers.expect_saved()
    # VS Code saves what it hears of in this way.
    towers.page.evaluate(
        "document.addEventListener('click', (e) => (window.saved = e.composedPath().find((node) => node.href)?.href))"
    )
    towers.button("Export scores").click()
    with towers.page.expect_download() as download:
        towers.page.get_by_role("button", name="JSONL").click()
    file = tmp_path / "scores.jsonl"
    download.value.save_as(file)
    assert towers.page.evaluate("saved").startswith("blob:")
    scores = sorted(json.loads(line)["score"] for line in file.read_text().splitlines())
    assert scores == [10.0, 20.0, 30.0, 40.0]
    towers.forget()
    towers.page.locator("input[type=file]").set_input_files(file)
    expect(towers.page.get_by_text("4 scores imported")).to_be_visible()
    assert towers.scores()[:5] == ["10", "20", "30", "40", ""]
    towers.button("Undo").click()
    expect(towers.page.locator(".gl-score").first).to_have_text("")
    labels = [json.loads(line) for line in file.read_text().splitlines()]
    small = [json.dumps(label | {"score": score}) for label, score in zip(labels, (None, 0, 0.5, 1), strict=True)]
    file.write_text("\n".join(small))
    towers.page.locator("input[type=file]").set_input_files(file)
    expect(towers.page.locator(".gl-outcome p")).to_have_text(
        [re.compile("^Note: 1 row without a score is left out"), re.compile("^Note: .*fractions of 100")]
    )
    file.write_text(json.dumps(labels[0]))
    towers.page.locator("input[type=file]").set_input_files(file)
    expect(towers.page.get_by_text("1 score imported")).to_be_visible()


def test_a_file_without_scores_is_refused_with_a_reason(towers, tmp_path):
    file = tmp_path / "scores.csv"
    file.write_text("this,is\nnot,it\n")
    towers.page.locator("input[type=file]").set_input_files(file)
    complaint = towers.page.locator(".gl-note.gl-bad:not(.gl-warnings)")
    expect(complaint).to_be_visible()
    complaint.get_by_role("button", name="Dismiss").click()
    expect(complaint).to_be_hidden()
