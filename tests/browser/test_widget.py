"""The same module as a widget of a notebook: a stand-in for anywidget's model that talks to a real session."""

from __future__ import annotations

from playwright.sync_api import expect

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


def test_keys_typed_in_the_widget_do_not_reach_the_notebook(opened, server):
    towers = opened(server.address)
    towers.page.evaluate("document.addEventListener('keydown', (event) => (window.heard ??= []).push(event.key))")
    towers.cell(2).click()
    towers.press("x", "b", "ArrowRight", "Control+a")
    assert towers.page.evaluate("window.heard ?? []") == []
