"""A real server and a real browser: Debian's Chromium, driven by Playwright."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import (
    Browser,
    BrowserContext,
    ConsoleMessage,
    Page,
    Playwright,
    Request,
    expect,
    sync_playwright,
)

from tests.browser.chromium import ARGUMENTS, CHROMIUM, needs_chromium
from tests.browser.driver import ScoringPage, Server
from tests.browser.late import LATE
from tests.waiting import PATIENCE

MILLISECONDS = 1000 * PATIENCE
SIZE = (1280, 800)

QUIET = "localStorage.grammarlab ??= JSON.stringify({ preview: false });"
"""Script of every window: without previews of models, which take long without a graphics card."""

expect.set_options(timeout=MILLISECONDS)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(needs_chromium)


# For the tests of this folder only: while Playwright is there its event loop runs, and other tests need loops of their
# own.
@pytest.fixture(scope="package")
def playwright() -> Iterator[Playwright]:
    with sync_playwright() as started:
        yield started


@pytest.fixture(scope="package")
def browser(playwright: Playwright) -> Iterator[Browser]:
    chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
    yield chromium
    chromium.close()


@pytest.fixture(scope="package")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """One server for all modules, on the small grammar; those that learn from scores have one of their own."""
    running = Server("toy", tmp_path_factory.mktemp("session") / "towers.db").start()
    yield running
    running.kill()


@pytest.fixture
def windows(browser: Browser) -> Iterator[Any]:
    """Opens a page in a window of its own: ``windows(address, color_scheme="dark")``.

    Whatever the page says wrong, and every request that would leave this machine, fails the test.
    """
    contexts: list[BrowserContext] = []
    wrong: list[str] = []

    def check_request(request: Request) -> None:
        if not is_local(request.url):
            wrong.append(f"left this machine: {request.url}")

    def check_message(message: ConsoleMessage) -> None:
        if message.type == "error":
            wrong.append(message.text)

    def open_page(address: str, **options: Any) -> Page:
        width, height = options.pop("size", SIZE)
        script = options.pop("script", "")
        # Without a graphics card every frame of a movement that runs out softly takes time.
        calm: dict[str, Any] = {"reduced_motion": "reduce", **options}
        context = browser.new_context(viewport={"width": width, "height": height}, **calm)
        contexts.append(context)
        context.add_init_script(LATE + QUIET + script)
        page = context.new_page()
        page.set_default_timeout(MILLISECONDS)
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("request", check_request)
        page.on("console", check_message)
        page.goto(address)
        return page

    yield open_page
    for context in contexts:
        context.close()
    # A server that was killed in a test is missed, and the page goes on trying.
    assert [text for text in wrong if "ERR_CONNECTION_REFUSED" not in text and "WebSocket" not in text] == []


@pytest.fixture
def opened(windows: Any) -> Any:
    """Opens the page of a server: ``opened(server.address, color_scheme="dark")``."""

    def open_page(address: str, **options: Any) -> ScoringPage:
        shown = ScoringPage(windows(address, **options))
        expect(shown.cell(0)).to_be_visible()
        return shown

    return open_page


def is_local(url: str) -> bool:
    """Whether a request stays on this machine."""
    return url.startswith(("http://127.0.0.1:", "blob:http://127.0.0.1:", "data:", "file:", "blob:null/"))


@pytest.fixture
def towers(opened: Any, server: Server) -> ScoringPage:
    """The page of the shared server, with no scores and nothing selected."""
    page = opened(server.address)
    page.forget()
    return page
