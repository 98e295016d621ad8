"""A rule file watched in several windows."""

from __future__ import annotations

from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.language.presets import RuleChoices
from grammarlab.pages import STATIC
from grammarlab.pages.desk import DESK_COMMANDS, Command
from grammarlab.pages.desktop import DeskHooks, Desktop, StateEvent
from grammarlab.pages.requests import Request
from grammarlab.pages.server import built_page
from grammarlab.pages.watch.desk import WatchDesk
from grammarlab.pages.windows import Message
from grammarlab.pages.workers.worker_pool import WorkerPool
from grammarlab.runs.sample.domains import SPECIES
from grammarlab.runs.sample.shipped import find_rules

PAGE = built_page("watch", "grammarlab watch", max_bytes=64 << 10)
_POLL_SECONDS = 0.15
"""Interval of looking at the file."""
_NICENESS = 5
_VIEWER = STATIC / "scoring" / "viewer.js"
_LARGEST = 2**53
"""Largest integer of a page."""


class Watcher(Desktop[WatchDesk]):
    """A rule file as a model that follows every save."""

    def __init__(self, grammar: str, *, assets: Path | None = None, library: Path | None = None) -> None:
        """Watch a rule file; it may have errors.

        Args:
            grammar: a rule file, or the name of a shipped one.
            assets: folder of assets, by default the one beside the file.
            library: folder of further projects that the file imports from.

        Raises:
            UsageError: If there is no such file, or it describes a species.
        """
        source = find_rules(grammar, assets, RuleChoices(library))
        if source.suffix == SPECIES:
            raise UsageError(f"{source.path}: expected a rule file; a species of trees has no rules to watch.")
        hooks: DeskHooks[WatchDesk] = DeskHooks(poll=WatchDesk.poll, poll_seconds=_POLL_SECONDS, close=WatchDesk.close)

        def make(desktop: Desktop[WatchDesk]) -> WatchDesk:
            bench, artist = (
                WorkerPool(
                    make="grammarlab.pages.watch.modeler:modeler",
                    arguments=(str(source.path), str(assets or ""), str(library or "")),
                    size=1,
                    deliver=desktop.post,
                    politeness=politeness,
                )
                for politeness in (0, _NICENESS)
            )
            return WatchDesk(source, bench, artist, desktop.tell)

        super().__init__(make, COMMANDS, _state_event, hooks)


def _state_event(desk: WatchDesk) -> StateEvent:
    return {"event": "state", "state": desk.state()}, ()


def _state(desk: WatchDesk, _request: Request) -> Message:
    return desk.state()


def _want(desk: WatchDesk, request: Request) -> Message:
    desk.want(request.integer("seed", 0, _LARGEST, desk.wanted.seed), request.integer("model", 0, _LARGEST, 0))
    return {}


def _roll(desk: WatchDesk, _request: Request) -> Message:
    desk.roll()
    return {"seed": desk.wanted.seed}


def _set(desk: WatchDesk, request: Request) -> Message:
    value = None if request.values.get("value") is None else request.text("value")
    desk.set_attribute(request.text("name"), value)
    return {}


def _sheet(desk: WatchDesk, _request: Request) -> Message:
    desk.draw_sheet()
    return {}


def _model(desk: WatchDesk, request: Request) -> None:
    request.answer({"version": desk.version, "tree": list(desk.tree)}, (desk.glb,))


def _part(desk: WatchDesk, request: Request) -> None:
    kind = "triangle" if "triangle" in request.values else "part"
    desk.find_part({kind: request.integer(kind, -_LARGEST, _LARGEST, 0)}, request.answer, request.refuse)


def _viewer(_desk: WatchDesk, request: Request) -> None:
    request.answer({}, (_VIEWER.read_bytes(),))


COMMANDS: dict[str, Command[WatchDesk]] = {
    **DESK_COMMANDS,
    "state": _state,
    "want": _want,
    "roll": _roll,
    "set": _set,
    "sheet": _sheet,
    "model": _model,
    "part": _part,
    "viewer": _viewer,
}
"""Functions of commands."""
