"""The widget in JupyterLab, in a real browser."""

import os
import socket
import subprocess
import sys

import pytest

from tests.browser.chromium import ARGUMENTS, CHROMIUM, needs_chromium
from tests.waiting import PATIENCE, wait_until

ACCESS = "for-this-test-only"
CELL = """
import grammarlab as gl
session = gl.ScoringSession("toy", path="toys.db", size=200, jobs=1)
session
"""
KERNEL_IS_IDLE = """() => {
    const kernel = window.jupyterapp.shell.currentWidget?.context?.sessionContext?.session?.kernel;
    return kernel?.status === "idle" && kernel.connectionStatus === "connected";
}"""

pytestmark = needs_chromium


def write_notebook(folder):
    import nbformat  # takes seconds, which no other test waits for

    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(CELL)])
    notebook.metadata.kernelspec = {"name": "python3", "display_name": "Python 3", "language": "python"}
    nbformat.write(notebook, folder / "scoring.ipynb")


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def is_listening(port):
    try:
        socket.create_connection(("127.0.0.1", port)).close()
    except OSError:
        return False
    return True


@pytest.fixture
def lab(tmp_path):
    """Address of a running JupyterLab whose folder holds a notebook with the widget."""
    notebooks = tmp_path / "notebooks"
    notebooks.mkdir()
    write_notebook(notebooks)
    port = free_port()
    folders = (
        "JUPYTER_CONFIG_DIR",
        "JUPYTER_RUNTIME_DIR",
        "IPYTHONDIR",
        "JUPYTERLAB_SETTINGS_DIR",
        "JUPYTERLAB_WORKSPACES_DIR",
    )
    environment = os.environ | {name: str(tmp_path / name.lower()) for name in folders}
    options = [
        "--no-browser",
        "--allow-root",
        f"--port={port}",
        "--ServerApp.ip=127.0.0.1",
        f"--IdentityProvider.token={ACCESS}",
        f"--ServerApp.root_dir={notebooks}",
        "--LabApp.expose_app_in_browser=True",
        "--LabApp.news_url=None",
        "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
    ]
    log = (tmp_path / "lab.log").open("w")
    server = subprocess.Popen(
        [sys.executable, "-m", "jupyterlab", *options], env=environment, stdout=log, stderr=subprocess.STDOUT
    )
    address = f"http://127.0.0.1:{port}"
    wait_until(lambda: is_listening(port), (tmp_path / "lab.log").read_text)
    yield f"{address}/lab/tree/scoring.ipynb?token={ACCESS}"
    server.terminate()
    server.wait(PATIENCE)
    log.close()


@pytest.fixture
def page():
    """A page of Chromium that remembers every address it asked for."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        page = browser.new_page(viewport={"width": 1500, "height": 1100})
        page.set_default_timeout(1000 * PATIENCE)
        yield page
        browser.close()


def test_scores_given_in_jupyterlab_are_in_the_session_file_also_after_a_cell_was_run_again(lab, page, tmp_path):
    from grammarlab.pages.record.label_exchange import read_labels_or_session

    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(lab)
    page.wait_for_function("window.jupyterapp?.restored")
    page.wait_for_function(KERNEL_IS_IDLE)
    page.evaluate("window.jupyterapp.commands.execute('notebook:run-all-cells')")
    cell = page.locator(".gl-cell").first
    cell.wait_for()
    cell.click()
    page.keyboard.press("7")
    page.get_by_text("saved").first.wait_for()
    labels, _ = read_labels_or_session(tmp_path / "notebooks" / "toys.db")
    assert labels.scores.tolist() == [70]
    first = page.locator(".gl-page").element_handle()
    page.evaluate("window.jupyterapp.commands.execute('notebook:run-all-cells')")
    page.wait_for_function("page => !page.isConnected && document.querySelector('.gl-cell')", arg=first)
    page.locator(".gl-score").first.filter(has_text="70").wait_for()
    page.locator(".gl-cell").nth(1).click()
    page.keyboard.press("3")
    page.get_by_text("saved").first.wait_for()
    labels, _ = read_labels_or_session(tmp_path / "notebooks" / "toys.db")
    assert labels.scores.tolist() == [70, 30]
    hosts = {url.split("/")[2] for url in asked if url.startswith(("http", "ws"))}
    assert {host.split(":")[0] for host in hosts} == {"127.0.0.1"}
