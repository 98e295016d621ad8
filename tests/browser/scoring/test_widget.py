"""The same module as a widget of a notebook: a stand-in for anywidget's model that talks to a real session."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from tests.browser.scoring.test_page import contrast
from tests.cases import takes_turns

RENDER = """
async () => {
  const socket = new WebSocket(`ws://${location.host}/socket${location.search}`);
  socket.binaryType = 'arraybuffer';
  await new Promise((opened) => { socket.onopen = opened; });
  const listeners = new Set();
  let message, buffers;
  socket.onmessage = ({ data }) => {
    if (typeof data === 'string') [message, buffers] = [JSON.parse(data), []];
    else buffers.push(new DataView(data));
    if (buffers.length === message.buffers) for (const listener of listeners) listener(message, buffers);
  };
  const model = {
    send(content, callbacks, parts) {
      socket.send(JSON.stringify({ ...content, buffers: parts.length }));
      for (const part of parts) socket.send(part);
    },
    on: (event, listener) => event === 'msg:custom' && listeners.add(listener),
    off: (event, listener) => listeners.delete(listener),
  };
  const widget = (await import(`/page.js${location.search}`)).default;
  const el = document.createElement('div');
  el.id = 'widget';
  document.body.replaceChildren(el);
  document.body.className = '';
  document.body.dataset.jpThemeLight = 'false';
  window.leave = await widget.render({ model, el });
  window.listening = () => listeners.size;
}
"""


def test_the_page_works_as_a_widget_and_goes_without_a_trace(opened, server):
    towers = opened(server.address)
    towers.page.evaluate(RENDER)
    expect(towers.cells).to_have_count(32)
    towers.expect_pictures()
    towers.cell(0).click()
    towers.press("5")
    towers.expect_saved()
    assert towers.scores()[0] == "50"
    root = towers.page.locator("#widget .gl-page")
    expect(root).to_have_css("color-scheme", "dark")
    expect(root).to_have_attribute("data-lm-suppress-shortcuts", "true")
    towers.cell(1).dblclick()
    expect(towers.page.locator(".gl-look-note")).to_have_text("")
    towers.press("Escape")
    towers.page.evaluate("leave()")
    expect(root).to_have_count(0)
    assert towers.page.evaluate("listening()") == 0


THEMES = {
    "light": "--jp-layout-color1: white; --jp-layout-color2: #eee; --jp-ui-font-color1: rgba(0, 0, 0, .87)",
    "dark": "--jp-layout-color1: #212121; --jp-layout-color2: #424242; --jp-ui-font-color1: rgba(255, 255, 255, .87)",
}
"""Of JupyterLab."""


@pytest.mark.parametrize("theme", THEMES)
def test_text_can_be_read_in_the_themes_of_jupyterlab(opened, server, theme):
    # The system is of the other kind; the notebook's theme counts.
    towers = opened(server.address, color_scheme="light" if theme == "dark" else "dark")
    towers.page.evaluate(RENDER)
    towers.page.evaluate(
        "([light, style]) => { document.body.dataset.jpThemeLight = light; document.body.style.cssText += style; }",
        [str(theme == "light").lower(), THEMES[theme]],
    )
    expect(towers.page.locator(".gl-page")).to_have_css("color-scheme", theme)
    for part in (
        ".gl-name",
        ".gl-title",
        ".gl-hint",
        ".gl-legend",
        ".gl-tab span",
        ".gl-count",
        ".gl-about",
        ".gl-check",
    ):
        assert contrast(towers.page.locator(part).first) >= 4.5, part


@takes_turns
def test_the_page_lives_in_a_shadow_tree_as_well(opened, server):
    """Some notebooks keep each output in one, with styles of its own."""
    towers = opened(server.address)
    towers.forget()
    towers.page.evaluate(
        RENDER.replace(
            "document.body.replaceChildren(el);",
            """const host = document.createElement('div');
            const style = new CSSStyleSheet();
            style.replaceSync(await (await fetch(`/page.css${location.search}`)).text());
            host.attachShadow({ mode: 'open' }).append(el);
            host.shadowRoot.adoptedStyleSheets = [style];
            document.body.replaceChildren(host);""",
        )
    )
    towers.expect_pictures()
    towers.cell(0).click()
    towers.press("s")
    towers.page.keyboard.type("7")
    # News that arrive meanwhile leave what is being typed.
    other = opened(server.address)
    other.cell(3).click()
    other.press("2")
    expect(towers.cell(3).locator(".gl-score")).to_have_text("20")
    towers.page.keyboard.type("5")
    towers.press("Enter")
    towers.expect_saved()
    assert towers.scores()[0] == "75"
    towers.press("c")
    pairs = towers.page.locator(".gl-compare")
    expect(pairs).to_be_focused()
    towers.press("ArrowLeft")
    expect(pairs).to_contain_text("Pair 2 of 8")
    towers.expect_saved()
    towers.press("u", "c")
    expect(towers.cell(0)).to_be_focused()
    towers.page.get_by_role("button", name="Grid").press("Enter")
    towers.press("ArrowDown", "ArrowDown")
    expect(towers.page.get_by_role("radio", name="2 of 6")).to_be_focused()
    towers.press("Escape")
    before = towers.cell(5).bounding_box()
    towers.button("Zoom in").click()
    assert towers.cell(5).bounding_box()["width"] > before["width"]


def test_a_page_says_that_python_ended_the_session(opened, server):
    towers = opened(server.address)
    towers.page.evaluate(
        RENDER.replace(
            "window.leave", "window.hear = (message) => listeners.forEach((each) => each(message, [])); window.leave"
        )
    )
    expect(towers.cells).to_have_count(32)
    towers.page.evaluate("hear({ event: 'closed', message: 'The session has been closed.' })")
    expect(towers.page.get_by_role("alert").filter(has_text="The session has been closed.")).to_be_visible()


def test_keys_typed_in_the_widget_do_not_reach_the_notebook(opened, server):
    towers = opened(server.address)
    towers.page.evaluate("document.addEventListener('keydown', (event) => (window.heard ??= []).push(event.key))")
    towers.cell(2).click()
    towers.press("x", "b", "ArrowRight", "Control+a")
    assert towers.page.evaluate("window.heard ?? []") == []
