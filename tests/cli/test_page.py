"""How a browser is started."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from grammarlab.cli.page import page_opener
from tests.waiting import wait_until

ADDRESS = "http://127.0.0.1:8000/?token=secret"

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="browsers are started by xdg-open on Linux")


def test_the_token_is_not_in_the_arguments_of_the_browser(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    browser = tmp_path / "xdg-open"
    browser.write_text(f'#!/bin/sh\necho "$@" > {tmp_path}/part\nmv {tmp_path}/part {tmp_path}/arguments\n')
    browser.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with page_opener("note", browser=True) as announce:
        announce(ADDRESS)
        wait_until((tmp_path / "arguments").exists)
        file = Path((tmp_path / "arguments").read_text().strip())
        assert "secret" not in str(file)
        assert ADDRESS in file.read_text()
    assert not file.exists()
    assert capsys.readouterr() == (f"{ADDRESS}\n", "note\n")


def test_a_browser_that_cannot_be_started_does_not_stop_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setenv("XDG_RUNTIME_DIR", "")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "missing"))
    with page_opener("note", browser=True) as announce:
        announce(ADDRESS)
    output = capsys.readouterr()
    assert output.out == f"{ADDRESS}\n"
    assert "open the address above" in output.err


def test_without_a_browser_no_file_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with page_opener("note", browser=False) as announce:
        announce(ADDRESS)
        assert list(tmp_path.iterdir()) == []
