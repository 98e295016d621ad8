"""The file that leads a browser to a page: private, readable by the browser, and gone in the end."""

from __future__ import annotations

import os
import stat
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

from grammarlab.pages.redirect import redirect

ADDRESS = "http://127.0.0.1:8000/?token=secret&a=\"'<b>"

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="modes of files are those of POSIX")


class Refresh(HTMLParser):
    """The address that a page leads to."""

    address = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        if values.get("http-equiv") == "refresh":
            self.address = (values["content"] or "").removeprefix("0;url=")


def desktop(folder: Path, monkeypatch: pytest.MonkeyPatch, browser: str) -> None:
    """A desktop with a browser, by its desktop file."""
    settings = folder / "bin" / "xdg-settings"
    settings.parent.mkdir()
    settings.write_text(f"#!/bin/sh\necho '{browser}'\n")
    settings.chmod(0o755)
    monkeypatch.setenv("PATH", f"{settings.parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("HOME", str(folder / "home"))
    (folder / "home" / "snap" / "firefox" / "common").mkdir(parents=True)
    (folder / "runtime").mkdir()
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder / "runtime"))


def test_only_its_user_reads_the_file_and_it_is_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    desktop(tmp_path, monkeypatch, "chromium.desktop")
    umask = os.umask(0)
    try:
        with redirect(ADDRESS) as file:
            assert file.parent == tmp_path / "runtime"
            assert stat.S_IMODE(file.stat().st_mode) == 0o600
            text = file.read_text(encoding="utf-8")
    finally:
        os.umask(umask)
    page = Refresh()
    page.feed(text)
    assert page.address == ADDRESS
    assert list((tmp_path / "runtime").iterdir()) == []


@pytest.mark.parametrize(
    ("browser", "folder"),
    [
        ("firefox_firefox.desktop", "home/snap/firefox/common"),
        ("brave_brave.desktop", "runtime"),
        ("../../etc_x.desktop", "runtime"),
        ("", "runtime"),
    ],
)
def test_a_browser_in_a_snap_gets_a_file_that_it_may_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, browser: str, folder: str
):
    desktop(tmp_path, monkeypatch, browser)
    with redirect(ADDRESS) as file:
        assert file.parent == tmp_path / folder


@pytest.mark.parametrize("runtime", ["", "relative", "/does/not/exist"])
def test_without_a_runtime_folder_it_is_a_temporary_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, runtime: str):
    desktop(tmp_path, monkeypatch, "")
    monkeypatch.setenv("XDG_RUNTIME_DIR", runtime)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with redirect(ADDRESS) as file:
        assert file.parent == tmp_path
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
