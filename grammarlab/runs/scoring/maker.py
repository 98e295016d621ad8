"""Makes files of a session and reads them, in a process of its own: labels, learned grammars, pictures of samples."""

from __future__ import annotations

import io
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from PIL import Image

from grammarlab.derivation.derive import derive
from grammarlab.errors import AssetError, GrammarlabError, UsageError
from grammarlab.files import write_text
from grammarlab.language.grammar import Grammar, read_text
from grammarlab.learning.pool import Pool
from grammarlab.preference.label_files import read_labels, save_labels
from grammarlab.runs.derive_batch import compiled
from grammarlab.runs.examples import SUFFIX
from grammarlab.runs.executors import SERIAL
from grammarlab.runs.scoring.crew import Handler, Report
from grammarlab.runs.scoring.labels import labels_of, scores_of
from grammarlab.runs.scoring.tasks import DrawSheet, Factors, LearnedFile, LearnGrammar, ReadLabels, WriteLabels
from grammarlab.runs.sheet_page import draw_page, lay_out
from grammarlab.runs.tiles import draw_tiles
from grammarlab.scene import realize, triangles

TILE_AREA = 240 * 240
"""Pixels of the picture of one model."""


def maker(text: str, name: str, assets: str, session: str, seed: int, size: int) -> Handler:
    """What makes and reads the files of a session, whose pool is of that seed and size."""
    return _Maker(compiled(text, name)[0], name, Path(assets), Path(session), Pool(seed, size)).do


def learned_name(session: Path) -> str:
    """What the learned grammar of a session is called."""
    return f"{session.stem}-learned{SUFFIX}"


@dataclass(frozen=True)
class _Maker:
    """Where files go."""

    grammar: Grammar
    name: str
    assets: Path
    session: Path
    pool: Pool

    def do(self, request: WriteLabels | ReadLabels | LearnGrammar | DrawSheet, report: Report) -> Any:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "labels")
            if isinstance(request, WriteLabels):
                file = file.with_suffix(request.suffix)
                save_labels(labels_of(request.factors, self.grammar.hash), file)
                return file.read_bytes()
            if isinstance(request, ReadLabels):
                return self._read(request, file)
            if isinstance(request, LearnGrammar):
                return self._learn(request, Path(folder), report)
            return self._sheet(request, report)

    def _read(self, request: ReadLabels, file: Path) -> Factors:
        file = file.with_suffix(request.suffix)
        file.write_bytes(request.content)
        try:
            labels = read_labels(file)
        except AssetError as error:
            # Where it lies for a moment says nothing to anybody.
            raise AssetError(str(error).replace(str(file), "the file")) from error
        return scores_of(labels, self.grammar.hash)

    def _learn(self, request: LearnGrammar, folder: Path, report: Report) -> LearnedFile:
        # These load JAX, which labels and sheets need not wait for.
        from grammarlab.density.learned import LearnedGrammar  # noqa: PLC0415
        from grammarlab.runs.learn.labels import learn_from_labels  # noqa: PLC0415

        if not any(any(scores.values()) for scores in request.factors.values()):
            raise UsageError("nothing is liked yet, so there is nothing to sample: score at least one model above 0.")
        report("learning the grammar", 0, 1)
        # The rule file may have changed since the session began, so its own text is learned from.
        rules, file = folder / f"{self.name}{SUFFIX}", folder / "labels.parquet"
        write_text(rules, self.grammar.text)
        (folder / "assets").symlink_to(self.assets.resolve(), target_is_directory=True)
        save_labels(labels_of(request.factors, self.grammar.hash), file)
        target = self.session.with_name(learned_name(self.session))
        result = learn_from_labels(str(rules), file, target, pool=replace(self.pool, wide=request.wide))
        learned = result.learned
        if not isinstance(learned, LearnedGrammar):
            raise GrammarlabError("the scores gave no grammar.")
        rules = learned.rules_before, learned.rules_after
        return LearnedFile(target.name, learned.text, result.density.measured.after.js, *rules, tuple(learned.findings))

    def _sheet(self, request: DrawSheet, report: Report) -> bytes:
        file = self.session.with_name(learned_name(self.session))
        if not file.is_file():
            raise UsageError("there is no learned grammar to sample yet; learn it first.")
        grammar, _ = compiled(read_text(file), file.stem)
        report("drawing samples", 0, 1)
        batch = triangles(realize(derive(grammar, request.num, request.seed, assets=self.assets)))
        models = [batch.model(index) for index in range(request.num)]
        # The session's other processes have the other cores.
        tiles = draw_tiles(models, TILE_AREA, SERIAL)
        page = lay_out(request.num, 0, tiles.width, tiles.height)
        captions = [(str(index), "") for index in range(request.num)]
        picture = draw_page(page, tiles.pictures, captions, (file.stem, f"seed {request.seed}"))
        content = io.BytesIO()
        Image.fromarray(picture).save(content, "PNG")
        return content.getvalue()
