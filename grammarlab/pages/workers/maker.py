"""Files of a session, written and read in a worker process: labels, learned grammars, pictures of samples."""

from __future__ import annotations

import io
import tempfile
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from PIL import Image

from grammarlab.asset_roots import AssetRoot, library_of, own_folder
from grammarlab.errors import AssetError, UsageError
from grammarlab.files import write_text
from grammarlab.language.presets import RuleChoices
from grammarlab.learning.designs.addresses import renamed
from grammarlab.learning.designs.pool import Pool
from grammarlab.pages.record.label_exchange import labels_of, replaced_notes, scores_of
from grammarlab.pages.workers.tasks import (
    DrawSheet,
    LabelledFactors,
    LearnedFile,
    LearnGrammar,
    ReadLabels,
    WriteLabels,
)
from grammarlab.pages.workers.worker_pool import Handler, Report
from grammarlab.preference.label_files import read_labels, save_labels
from grammarlab.runs.sample.contact_sheet import draw_page, draw_tiles, lay_out
from grammarlab.runs.sample.domains import domain_of, opened
from grammarlab.runs.work.executors import SERIAL
from grammarlab.scene import triangles

TILE_AREA = 240 * 240
"""Pixels of the picture of one model."""


def maker(suffix: str, text: str, name: str, assets: AssetRoot, session: str, seed: int, size: int) -> Handler:
    """Worker that writes and reads the files of a session with a pool of a given seed and size."""
    return _Maker(suffix, text, name, assets, Path(session), Pool(seed, size)).do


@dataclass(frozen=True)
class _Maker:
    """Folder of the files."""

    suffix: str
    text: str
    name: str
    assets: AssetRoot
    session: Path
    pool: Pool

    @cached_property
    def hash(self) -> str:
        """Hashes of the models in labels."""
        return opened(self.suffix, self.text, self.name, self.assets).hashes[0]

    @property
    def learned(self) -> Path:
        """Path of the learned file."""
        return self.session.with_name(f"{self.session.stem}-learned{self.suffix}")

    def do(self, request: WriteLabels | ReadLabels | LearnGrammar | DrawSheet, report: Report) -> Any:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "labels")
            if isinstance(request, WriteLabels):
                file = file.with_suffix(request.suffix)
                save_labels(labels_of(request.factors, self.hash), file)
                return file.read_bytes()
            if isinstance(request, ReadLabels):
                return self._read(request, file)
            if isinstance(request, LearnGrammar):
                return self._learn(request, Path(folder), report)
            return self._sheet(request, report)

    def _read(self, request: ReadLabels, file: Path) -> LabelledFactors:
        file = file.with_suffix(request.suffix)
        file.write_bytes(request.content)
        try:
            labels = read_labels(file)
        except AssetError as error:
            # The temporary path is not shown.
            raise AssetError(str(error).replace(str(file), "the file")) from error
        factors = scores_of(renamed(labels, self.text), self.hash)
        return LabelledFactors(factors, (*labels.notes, *replaced_notes(len(labels), factors)))

    def _learn(self, request: LearnGrammar, folder: Path, report: Report) -> LearnedFile:
        # It loads JAX, which labels and sheets do not need.
        from grammarlab.runs.learn.from_labels import learn_from_labels  # noqa: PLC0415

        if not any(judgement.is_positive for scores in request.factors.values() for judgement in scores.values()):
            raise UsageError("nothing is liked yet, so there is nothing to sample: score at least one model above 0.")
        report("learning from the scores", 0, 1)
        # The file may have changed since the session began, so its own text is learned from.
        rules = folder / f"{self.name}{self.suffix}"
        write_text(rules, self.text)
        (folder / "assets").symlink_to(own_folder(self.assets).resolve(), target_is_directory=True)
        result = learn_from_labels(
            str(rules),
            labels_of(request.factors, self.hash),
            self.learned,
            labels_from=self.session.name,
            pool=replace(self.pool, wide=request.wide),
            choices=RuleChoices(library_of(self.assets)),
            on_progress=report,
        )
        learned, density = result.learned, result.density
        rules = learned.rules_before, learned.rules_after
        notes = (*density.predicted.words.knowledge, *learned.findings)
        return LearnedFile(self.learned.name, learned.text, density.measured.after.js, *rules, notes)

    def _sheet(self, request: DrawSheet, report: Report) -> bytes:
        file = self.learned
        if not file.is_file():
            raise UsageError("there is no learned file to sample yet; learn it first.")
        space = opened(self.suffix, domain_of(self.suffix).read(file), file.stem, self.assets)
        report("drawing samples", 0, 1)
        batch = triangles(space.scene(request.num, request.seed))
        models = [batch.model(index) for index in range(request.num)]
        # The session's other processes have the other cores.
        tiles = draw_tiles(models, TILE_AREA, SERIAL)
        page = lay_out(request.num, 0, tiles.width, tiles.height)
        captions = [(str(index), "") for index in range(request.num)]
        picture = draw_page(page, tiles.pictures, captions, (file.stem, f"seed {request.seed}"))
        content = io.BytesIO()
        Image.fromarray(picture).save(content, "PNG")
        return content.getvalue()
