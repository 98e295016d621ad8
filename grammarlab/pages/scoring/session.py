"""Scoring session for any transport."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypedDict

from grammarlab.errors import GrammarlabError
from grammarlab.language.presets import NO_CHOICES, RuleChoices
from grammarlab.pages.desktop import DeskHooks, Desktop
from grammarlab.pages.record.opening import Opening, open_session
from grammarlab.pages.record.store import Store
from grammarlab.pages.scoring.commands import COMMANDS
from grammarlab.pages.scoring.desk import SessionDesk
from grammarlab.pages.scoring.state import state_event
from grammarlab.pages.workers.tasks import Begin
from grammarlab.pages.workers.worker_pool import TaskOutcome, WorkerPool
from grammarlab.runs.sample.domains import opened
from grammarlab.runs.work.workers import available_cores, end_if_unguarded

CLOSED = "The session has been closed; what was scored is saved. Open it again to go on."
POLL_SECONDS = 0.4
"""Interval of reading the file for events of other processes."""


class SessionOptions(TypedDict, total=False):
    """Options of a session; see `Session`."""

    seed: int
    size: int | None
    assets: Path | None
    choices: RuleChoices
    stored_grammar: bool
    jobs: int | None


class Session(Desktop[SessionDesk]):
    """A scoring session: models, scores, and predictions learned from them."""

    def __init__(
        self,
        grammar: str,
        path: Path | str,
        *,
        seed: int = 0,
        size: int | None = None,
        assets: Path | None = None,
        choices: RuleChoices = NO_CHOICES,
        stored_grammar: bool = False,
        jobs: int | None = None,
        phrase: Callable[[str], str] = str,
    ) -> None:
        """Open a session file, or create one.

        Args:
            grammar: a rule file, a species of trees, or the name of a shipped one.
            path: the session file.
            seed: seed of the models of a new session, 0 <= seed < 2**64.
            size: size of the pool of a new session; by default the usual one of its designs.
            assets: folder of meshes and images, if it is not the one beside the file.
            choices: choices of the user for a rule file.
            stored_grammar: use the grammar stored in the session, even if the file has changed.
            jobs: number of processes that draw; by default one per core, 0 for a session without pictures.
            phrase: says warnings, which name arguments, in the words of those who read the page.

        Raises:
            UsageError: If the session was created with another grammar.
            LanguageError: If the grammar has errors.
            AssetError: If the file is not a session.
            GrammarlabError: If a script without ``if __name__ == "__main__":`` begins a session.
        """
        end_if_unguarded()
        opening = open_session(
            grammar, Path(path), seed=seed, size=size, assets=assets, choices=choices, stored_grammar=stored_grammar
        )
        num_artists = available_cores() if jobs is None else jobs
        hooks: DeskHooks[SessionDesk] = DeskHooks(
            idle=SessionDesk.prepare_if_free,
            poll=lambda desk: desk.display.poll(),
            poll_seconds=POLL_SECONDS,
            forget=lambda desk, window: desk.thumbnails.forget(window),
            close=SessionDesk.close,
            closed=CLOSED,
        )
        super().__init__(partial(_open_desk, opening, num_artists, phrase), COMMANDS, state_event, hooks)


def _open_desk(
    opening: Opening, num_artists: int, phrase: Callable[[str], str], desktop: Desktop[SessionDesk]
) -> SessionDesk:
    about, store = opening.about, opening.store
    artists = WorkerPool(
        make="grammarlab.pages.workers.artist:artist",
        arguments=(about.suffix, about.grammar, about.title, opening.assets),
        size=num_artists,
        deliver=desktop.post,
    )
    try:
        artists.start()
        store = store or _new_store(opening, artists, desktop)
        return SessionDesk(opening.path, store, opening.assets, artists, desktop.tell, phrase)
    except BaseException:
        artists.close()
        if store is not None:
            store.close()
        raise


def _new_store(opening: Opening, artists: WorkerPool, desktop: Desktop[SessionDesk]) -> Store:
    """A new session file; none is made for a grammar with errors."""
    about = opening.about
    if artists.size:
        # The processes read the grammar in any case, so this process does not load those libraries.
        outcomes: list[TaskOutcome] = []
        artists.submit(Begin(), outcomes.append)
        desktop.run_until(lambda: bool(outcomes))
        if outcomes[0].error:
            raise GrammarlabError(outcomes[0].error)
        usual_size: int = outcomes[0].value
    else:
        usual_size = opened(about.suffix, about.grammar, about.title, opening.assets).pool_size
    return Store.open(opening.path, replace(about, size=usual_size) if opening.has_usual_size else about)
