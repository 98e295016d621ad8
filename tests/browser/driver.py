"""A server in a process of its own, and the page as a person sees it."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

from playwright.sync_api import Locator, Page, expect

TOKEN = "known-to-page-and-next-run"  # noqa: S105 - of servers that live for a test

NUM_SHOWN = 32
"""Number of models of a new session: those of two grids."""
SETTLED = """
() => Promise.allSettled(
  document.getAnimations().filter((each) => each instanceof CSSTransition).map((each) => each.finished)
)
"""


def settle(page: Page) -> None:
    """Waits until no colour or place is on its way to another."""
    page.evaluate(SETTLED)


class Server:
    """``grammarlab score`` in a process of its own, with rough pictures."""

    module = "tests.browser.rough"
    """Module of the command line."""

    def __init__(self, grammar: str, session: Path) -> None:
        self.grammar, self.session = grammar, session
        self.process: subprocess.Popen[str] | None = None
        self.address = ""

    def start(self, port: int = 0) -> Server:
        """Starts, and waits for the address."""
        command = [sys.executable, "-m", self.module, *self.arguments(), "--no-browser", "--port", str(port)]
        with (self.session.parent / "log.txt").open("a") as log:
            self.process = subprocess.Popen(
                command,
                env=os.environ | {"GRAMMARLAB_TOKEN": TOKEN, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
                stdout=subprocess.PIPE,
                stderr=log,
                text=True,
                start_new_session=True,
            )
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().strip()
        if not self.address.startswith("http://127.0.0.1:"):
            self.kill()
            raise RuntimeError((self.session.parent / "log.txt").read_text())
        return self

    def arguments(self) -> list[str]:
        """The command, less what it says about its server."""
        return ["score", self.grammar, "--session", str(self.session)]

    @property
    def port(self) -> int:
        found = re.search(r":(\d+)/", self.address)
        assert found
        return int(found[1])

    def kill(self) -> None:
        """Ends it and what it started, as a crash would."""
        if self.process is None:
            return
        os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()
        self.process = None


class ScoringPage:
    """The page as a person sees it: what one reads on it, and a few things that one does often."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.cells = page.get_by_role("option")
        self.saved = page.locator(".gl-saved")

    def cell(self, position: int) -> Locator:
        return self.cells.nth(position)

    def button(self, name: str) -> Locator:
        return self.page.get_by_role("button", name=name, exact=True)

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    def chosen(self) -> list[int]:
        """Positions of the selected models."""
        return self.look("cells => cells.flatMap((cell, i) => cell.ariaSelected === 'true' ? [i] : [])")

    def labels(self) -> list[str]:
        """What each tile says to a screen reader."""
        return self.look("cells => cells.map(cell => cell.ariaLabel)")

    def scores(self) -> list[str]:
        """The scores shown on the tiles, in order; empty where there is none."""
        return self.look("cells => cells.map(cell => cell.querySelector('.gl-score').textContent)")

    def models(self) -> list[str]:
        """Which models are shown."""
        return self.look("cells => cells.map(cell => cell.dataset.model)")

    def look(self, script: str) -> Any:
        return self.cells.evaluate_all(script)

    def expect_chosen(self, positions: list[int]) -> None:
        """Waits until just these are selected; the page draws with the next frame."""
        expect(self.page.locator(".gl-cell[aria-selected=true]")).to_have_count(len(positions))
        for position in positions:
            expect(self.cell(position)).to_have_attribute("aria-selected", "true")
        assert self.chosen() == sorted(positions)

    def expect_saved(self) -> None:
        expect(self.saved).to_have_text("saved")
        expect(self.page.locator(".gl-unsaved")).to_have_count(0)

    def expect_pictures(self) -> None:
        expect(self.page.locator(".gl-empty")).to_have_count(0)

    def forget(self) -> None:
        """Takes all scores away and selects nothing; models that an earlier test added below go, too."""
        self.cell(0).click()
        self.press("Control+a", "Delete", "Escape")
        self.expect_saved()
        expect(self.page.locator(".gl-cell .gl-score:not(:empty)")).to_have_count(0)
        if self.cells.count() > NUM_SHOWN:
            self.button("New models").click()
            expect(self.cells).to_have_count(NUM_SHOWN)

    def update(self) -> None:
        """Learns from all scores now, and waits for the models that come then."""
        models = self.models()
        self.press("Control+Enter")
        expect(self.page.locator(f'.gl-cell[data-model="{models[0]}"]')).to_have_count(0)
        expect(self.page.locator(".gl-busy:visible")).to_have_count(0)
