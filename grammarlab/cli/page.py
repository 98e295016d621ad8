"""Pages of commands: their address, and how a browser opens it."""

from __future__ import annotations

import shutil
import sys
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from threading import Thread

import typer

from grammarlab.cli.console import print_result, say


@contextmanager
def page_opener(note: str, *, browser: bool) -> Iterator[Callable[[str], None]]:
    """Function that prints the address of a page with a note, and opens it.

    The browser gets a private file that leads to the page, since others can read the arguments of a process. The file
    is removed at the end of the context.

    Args:
        note: printed on stderr, after the address on stdout.
        browser: whether the page is opened.
    """
    from grammarlab.pages.redirect import redirect

    with ExitStack() as stack:

        def announce(address: str) -> None:
            print_result(address)
            say(note)
            if not browser:
                return
            try:
                file = stack.enter_context(redirect(address))
            except OSError as error:
                say(f"the browser was not started ({error}); open the address above")
                return
            open_file(file)

        yield announce


def open_file(file: Path) -> None:
    """Open a file in the browser, on a thread of its own, since some browsers are waited for until they end."""
    Thread(target=_open, args=(file,), daemon=True).start()


def _open(file: Path) -> None:
    if sys.platform == "linux" and not shutil.which("xdg-open"):
        webbrowser.open(file.as_uri())
    else:
        typer.launch(str(file), wait=True)
