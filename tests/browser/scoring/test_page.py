"""For everyone: keys alone, screen readers, dark and light, narrow windows, no network."""

from __future__ import annotations

import re

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.browser.driver import settle
from tests.cases import takes_turns

LUMINANCE = """
(element) => {
  const canvas = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
  const luminance = (colour) => {
    canvas.fillStyle = colour;
    canvas.fillRect(0, 0, 1, 1);
    const parts = [...canvas.getImageData(0, 0, 1, 1).data].slice(0, 3).map((value) => value / 255);
    const [r, g, b] = parts.map((part) => part <= 0.03928 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  let behind = element;
  while (/rgba\\(.*, 0\\)|transparent/.test(getComputedStyle(behind).backgroundColor)) behind = behind.parentElement;
  return [getComputedStyle(element).color, getComputedStyle(behind).backgroundColor].map(luminance);
}
"""


def contrast(locator):
    """Of text against what is behind it, as WCAG 2 defines it."""
    settle(locator.page)
    return ratio(*locator.evaluate(LUMINANCE))


def ratio(*luminances):
    dark, light = sorted(luminances)
    return (light + 0.05) / (dark + 0.05)


SIGHT = {
    "all colours": np.eye(3),
    "no red": [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]],
    "no green": [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]],
    "no blue": [[1.256, -0.077, -0.179], [-0.078, 0.931, 0.148], [0.005, 0.691, 0.304]],
}
"""What becomes of linear red, green and blue where a kind of cone is missing (Machado, Oliveira and Fernandes 2009)."""
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def linear(colour):
    """Red, green and blue of ``rgb(…)`` as amounts of light."""
    parts = np.array([int(part) / 255 for part in re.findall(r"\d+", colour)[:3]])
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def lightness_and_hue(light):
    """CIE L*a*b* of an amount of light."""
    x, y, z = np.cbrt(np.clip(XYZ @ light, 1e-9, None) / XYZ.sum(axis=1))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_can_be_read_in_both_themes(opened, server, scheme):
    towers = opened(server.address, color_scheme=scheme)
    for part in (
        ".gl-name",
        ".gl-about",
        ".gl-title",
        ".gl-hint",
        ".gl-count",
        ".gl-legend",
        ".gl-tab span",
        ".gl-check",
    ):
        assert contrast(towers.page.locator(part).first) >= 4.5, part
    assert contrast(towers.button("New models")) >= 4.5
    light = towers.page.locator(".gl-page").evaluate(LUMINANCE)[1] > 0.5
    assert light == (scheme == "light")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_bars_are_seen_and_told_apart_by_everyone(opened, server, scheme):
    towers = opened(server.address, color_scheme=scheme)

    def light_of(selector, name="backgroundColor"):
        colour = towers.page.locator(selector).first.evaluate(f"element => getComputedStyle(element).{name}")
        return linear(colour)

    predicted, uncertain = light_of(".gl-predicted i"), light_of(".gl-uncertain i")
    behind, track = light_of(".gl-stage"), light_of(".gl-bar span")
    for bar in (predicted, uncertain):
        for other in (behind, track):
            assert ratio(XYZ[1] @ bar, XYZ[1] @ other) >= 3.0
    for sight, matrix in SIGHT.items():
        apart = lightness_and_hue(matrix @ predicted) - lightness_and_hue(matrix @ uncertain)
        assert np.linalg.norm(apart) > 40, sight


def test_everything_has_a_role_and_a_name(towers):
    nameless = towers.page.locator(
        "button, input, [role=listbox], [role=option], dialog, section[aria-label]"
    ).evaluate_all(
        """elements => elements.filter(element => !(
            element.ariaLabel || element.textContent.trim() || element.labels?.length || element.hidden ||
            element.getAttribute('aria-labelledby'))).map(element => element.outerHTML)"""
    )
    assert nameless == []
    grids = towers.page.get_by_role("listbox")
    for index in range(grids.count()):
        expect(grids.nth(index)).to_have_attribute("aria-multiselectable", "true")
        expect(grids.nth(index).locator("[tabindex='0']")).to_have_count(1)
    duplicates = "elements => elements.map(e => e.id).filter((id, index, all) => id && all.indexOf(id) !== index)"
    assert towers.page.locator("[id]").evaluate_all(duplicates) == []
    expect(towers.cell(0)).to_have_accessible_name(re.compile("^model .*, no score$|^model .*, no score, predicted"))
    towers.cell(0).click()
    towers.press("3")
    expect(towers.cell(0)).to_have_accessible_name(re.compile("scored 30"))
    expect(towers.page.get_by_role("status").filter(has_text="saved")).to_be_visible()


@takes_turns
def test_tab_goes_through_the_page_and_every_stop_can_be_seen(towers):
    seen, where = [], "() => document.activeElement.ariaLabel || document.activeElement.textContent"
    towers.button("Undo").focus()
    for _ in range(30):
        towers.press("Tab")
        seen.append(towers.page.evaluate(where)[:20])
        focus = towers.page.locator(":focus")
        if focus.count() and focus.get_attribute("role") != "option":
            assert focus.evaluate("element => getComputedStyle(element).outlineStyle") != "none", seen
    assert sum(name.startswith("model ") for name in seen) == 2  # one stop for each grid
    assert {"Sort", "Zoom in", "Drag to pan", "Export scores"} <= set(seen)


def test_a_whole_round_by_keys_alone(towers):
    towers.page.locator(".gl-grid [tabindex='0']").first.focus()
    towers.press("Home", "Shift+ArrowRight", "7", "ArrowDown", "s")
    towers.page.keyboard.type("35")
    towers.press("Enter")
    towers.expect_saved()
    assert towers.scores()[:6] == ["70", "70", "", "35", "", ""]
    towers.button("Sort").focus()
    towers.press("Enter")
    expect(towers.page.get_by_role("button", name="Predicted score highest first")).to_be_focused()
    towers.press("Escape")
    expect(towers.button("Sort")).to_be_focused()


def test_colours_that_mean_something_stay_where_the_system_chooses_colours(opened, server):
    towers = opened(server.address, forced_colors="active")
    settle(towers.page)
    bars = [towers.page.locator(f".gl-key.{name} i") for name in ("gl-predicted", "gl-uncertain")]
    first, second = (bar.evaluate("element => getComputedStyle(element).backgroundColor") for bar in bars)
    assert first != second
    pressed = towers.page.locator(".gl-tab[aria-pressed=true]")
    other = towers.button("Sort")
    assert pressed.evaluate("tab => getComputedStyle(tab).backgroundColor") != other.evaluate(
        "button => getComputedStyle(button).backgroundColor"
    )


def test_a_narrow_window_shows_everything_without_sideways_scrolling(opened, server):
    towers = opened(server.address, size=(390, 800))
    assert towers.page.evaluate("document.documentElement.scrollWidth") <= 390
    towers.cell(2).click()
    towers.button("50").click()
    towers.expect_saved()
    first, second = (towers.page.get_by_role("listbox").nth(index).bounding_box() for index in range(2))
    assert first["x"] == second["x"]
    towers.forget()


def test_movement_is_left_out_where_that_is_wished(opened, server):
    towers = opened(server.address, reduced_motion="reduce")
    moving = towers.page.locator(".gl-page *").evaluate_all(
        "elements => elements.filter(e => parseFloat(getComputedStyle(e).transitionDuration) > 0).length"
    )
    assert moving == 0
