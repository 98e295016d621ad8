"""Session and page of a built city in several windows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from grammarlab.pages.city.commands import COMMANDS, state_event
from grammarlab.pages.city.decisions import plan_of
from grammarlab.pages.city.desk import CityDesk
from grammarlab.pages.desktop import DeskHooks, Desktop
from grammarlab.pages.server import Page, built_page
from grammarlab.pages.workers.worker_pool import WorkerPool

REBUILD = "grammarlab.runs.city.rebuild:rebuild"
"""Function that builds parcels again (`grammarlab.pages.city.builder.Rebuild`)."""
_POLL_SECONDS = 1.0
"""Interval of looking for scores from elsewhere."""
_NICENESS = 5


def page_of(folder: Path) -> Page:
    """The page of the city in a folder, whose files it serves."""
    return replace(built_page("city", "grammarlab city open", max_bytes=64 << 10), folder=folder)


class CityViewer(Desktop[CityDesk]):
    """A city seen and changed in several windows; `grammarlab.pages.city.commands` has their requests."""

    def __init__(self, folder: Path, *, rebuild: str = REBUILD) -> None:
        """Open the folder of a built city.

        Args:
            folder: what ``grammarlab city build`` made. If its plan is gone, nothing can be changed.
            rebuild: ``package.module:function`` that builds parcels again.

        Raises:
            AssetError: If the folder is not that of a city.
            GrammarlabError: If the plan cannot be read.
        """
        hooks: DeskHooks[CityDesk] = DeskHooks(poll=CityDesk.poll, poll_seconds=_POLL_SECONDS, close=CityDesk.close)

        def make(desktop: Desktop[CityDesk]) -> CityDesk:
            builders, readers = (
                WorkerPool(
                    make="grammarlab.pages.city.builder:builder",
                    arguments=(rebuild,),
                    size=1,
                    deliver=desktop.post,
                    politeness=politeness,
                )
                for politeness in (_NICENESS, 0)
            )
            return CityDesk(folder, plan_of(folder), builders, readers)

        super().__init__(make, COMMANDS, state_event, hooks)
