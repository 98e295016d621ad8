"""Models of a rule file as it is now, in a worker process."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import starmap
from pathlib import Path

from PIL import Image

from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation.expressions import number_grammar
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.lots import DEFAULT_FOOTPRINT, Lots
from grammarlab.derivation.program import Program
from grammarlab.errors import DerivationError, Finding, GrammarlabError, LanguageError
from grammarlab.export.glb import merged_glb
from grammarlab.features.acceptance import Acceptance, derive_accepted
from grammarlab.language.attribute_values import read_attributes
from grammarlab.language.checking.check import CheckedFile, check_files
from grammarlab.language.grammar import Grammar, may_import, read_text
from grammarlab.language.presets import RuleChoices
from grammarlab.learning.designs.grammar_space import GrammarParts
from grammarlab.option_names import with_options
from grammarlab.pages.watch.controls import Control, controls_of
from grammarlab.pages.watch.part_tree import part_tree
from grammarlab.pages.watch.watch_tasks import DrawPicture, MadeModel, MakeModel, Mistake, Wanted
from grammarlab.pages.workers.artist import PartFinder
from grammarlab.pages.workers.tasks import FindPart, FoundPart
from grammarlab.pages.workers.worker_pool import Handler, Report
from grammarlab.rendering.camera import View, frame
from grammarlab.rendering.raycast import RaycastRenderer
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.runs.sample.checks import SUPPORTED, warnings_of
from grammarlab.runs.sample.contact_sheet import seen_points
from grammarlab.runs.sample.records import compiled
from grammarlab.runs.sample.shipped import RuleSource, find_rules
from grammarlab.scene import TriangleBatch, realize, triangles
from grammarlab.scene.scene_pictures import with_pictures

MAX_GLB_BYTES = 128 << 20
"""Largest size of a model for a window in bytes."""
_QUALITY = 88
"""Quality of JPEGs, 1 to 95."""
_MOST_REMARKS = 100
"""Largest number of findings on the page beside a model."""
_MOST_PRINTS = 20
"""Largest number of texts of `print` on the page."""
_LONGEST_PRINT = 200
"""Characters of a printed text on the page."""
_MOST_CODE = 200
"""Characters of a line on either side of a mistake."""


def modeler(file: str, assets: str, library: str = "") -> Handler:
    """Worker for `MakeModel`, `DrawPicture` and `FindPart` tasks of a rule file.

    Args:
        file: path of the file, or the name of a shipped one; it is read again for each model.
        assets: folder of assets; empty for the one beside the file.
        library: folder of further projects that the file imports from; empty for none.
    """
    folder, choices = Path(assets) if assets else None, RuleChoices(library or None)
    return _Bench(file=file, assets=folder, choices=choices).do


@dataclass(kw_only=True)
class _Bench:
    file: str
    assets: Path | None
    choices: RuleChoices
    part_finder: PartFinder | None = None
    merged: str = ""
    """The text of all files that was read last, merged."""
    read: Mapping[Path, str] = field(default_factory=dict)
    """Texts of these files, read before they were merged; none if one of them has changed since."""
    checked: tuple[CheckedFile, ...] = ()
    """These files, and what was found in them; none before they are checked."""

    def do(self, request: MakeModel | DrawPicture | FindPart, _report: Report) -> MadeModel | FoundPart | bytes:
        if isinstance(request, FindPart):
            if self.part_finder is None:
                raise GrammarlabError("there is no model; the rules have errors.")
            return self.part_finder.find(request.number, request.is_triangle)
        if isinstance(request, DrawPicture):
            return self._picture(request)
        return self._make(request.wanted)

    def _make(self, wanted: Wanted) -> MadeModel:
        self.part_finder = None
        controls: tuple[Control, ...] | None = None
        lines: list[str] = []
        try:
            source = find_rules(self.file, self.assets, self.choices)
            lines = self._text(source).splitlines()
            rules, program = compiled(self.merged, source.name)
            controls = controls_of(rules)
            forest, batch, folder = self._derive(source, rules, program, wanted)
            glb = _glb_of(batch, folder)
            numbering = number_grammar(rules)
            self.part_finder = PartFinder("", GrammarParts(forest, numbering))
            tree = tuple(part_tree(forest, numbering, self.file))
            passed_over = (*forest.warnings, *warnings_of(forest.missing_assets, folder))
            remarks = (*self._remarks(source, rules), *(_mistake_of(each, lines) for each in passed_over))
            mistakes = (*remarks[:_MOST_REMARKS], *_rest(len(remarks) - _MOST_REMARKS, "remarks", "check or sample"))
            return MadeModel(glb, len(forest.nodes), controls, (*mistakes, *_printed(forest.prints)), tree)
        except LanguageError as error:
            mistakes = tuple(_mistake_of(each, error.text.splitlines() or lines) for each in error.findings)
            return MadeModel(controls=controls, mistakes=mistakes)
        except DerivationError as error:
            return MadeModel(controls=controls, mistakes=(_mistake_of_derivation(error, lines),))
        except GrammarlabError as error:
            return MadeModel(controls=controls, mistakes=(Mistake("error", str(error)),))

    def _text(self, source: RuleSource) -> str:
        """The text of all files, merged; they are read again once one of them has changed, or if one was missing."""
        has_all = not any(finding.code == "bad-import" for each in self.checked for finding in each.findings)
        if not (self.read and has_all and all(starmap(_is_as_read, self.read.items()))):
            self.read, self.checked = {}, ()
            read = {source.path: _text_of(source.path)}
            if may_import(read[source.path]):
                self._check(source, None)
                read = {Path(each.file): each.text for each in self.checked}
            self.merged = source.text()
            self.read = read
        return self.merged

    def _check(self, source: RuleSource, rules: Grammar | None) -> None:
        """Find which files there are, and what is to be said of them."""
        if self.checked:
            return
        name, library = str(source.path), self.choices.library
        self.checked = check_files(source.path, name, SUPPORTED, library=library, known=rules)
        if self.read != {Path(each.file): each.text for each in self.checked}:  # saved since the model was begun
            self.read = {}

    def _remarks(self, source: RuleSource, rules: Grammar) -> tuple[Mistake, ...]:
        """What a check finds in the files themselves, as names that are neither rules nor operations."""
        self._check(source, rules)
        return tuple(
            _in_file(_mistake_of(finding, each.text.splitlines()), Path(each.file), source.path)
            for each in self.checked
            for finding in each.findings
        )

    @staticmethod
    def _derive(
        source: RuleSource, rules: Grammar, program: Program, wanted: Wanted
    ) -> tuple[Forest, TriangleBatch, AssetRoot]:
        # What a save has renamed or removed is no longer set.
        texts = [f"{name}={value}" for name, value in wanted.attributes if name in rules.attributes]
        values = read_attributes(texts, rules)
        lots = Lots.at(wanted.seed, wanted.model, DEFAULT_FOOTPRINT, values, None)
        forest = derive_accepted(program, Acceptance.of(rules.tree), lots, AssetFolder(source.assets)).forest
        return forest, triangles(with_pictures(realize(forest), source.assets)).model(0), source.assets

    def _picture(self, request: DrawPicture) -> bytes:
        source = find_rules(self.file, self.assets, self.choices)
        rules, program = compiled(self._text(source), source.name)
        self._check(source, rules)
        _, batch, _ = self._derive(source, rules, program, request.wanted)
        options = RenderOptions(width=request.size, height=request.size, samples=2)
        picture = RaycastRenderer().render(batch, frame(seen_points(batch), 1.0, View()), options)
        file = io.BytesIO()
        Image.fromarray(picture).save(file, "JPEG", quality=_QUALITY)
        return file.getvalue()


def _glb_of(batch: TriangleBatch, assets: AssetRoot) -> bytes:
    glb = merged_glb(batch, "model", assets)
    if len(glb) > MAX_GLB_BYTES:
        raise GrammarlabError(f"the model is too large to be shown: {len(glb) >> 20} MiB.")
    return glb


def _text_of(file: Path) -> str:
    """Text of a rule file as a check has it."""
    return read_text(file).removeprefix("\ufeff")


def _is_as_read(file: Path, text: str) -> bool:
    try:
        return _text_of(file) == text
    except LanguageError:  # removed
        return False


def _printed(texts: Sequence[str]) -> Iterator[Mistake]:
    """What the rules print."""
    shown = [Mistake("note", f"printed: {_cut(text)}") for text in texts[:_MOST_PRINTS]]
    yield from shown
    yield from _rest(len(texts) - len(shown), "printed lines", "sample")


def _cut(text: str) -> str:
    """The begin of a printed text, which may be a megabyte."""
    return text if len(text) <= _LONGEST_PRINT else f"{text[:_LONGEST_PRINT]} … ({len(text):,} characters)"


def _rest(num: int, what: str, commands: str) -> Iterator[Mistake]:
    """A note on what the page leaves out."""
    if num > 0:
        yield Mistake("note", f"… and {num:,} more {what}; grammarlab {commands} shows them")


def _in_file(mistake: Mistake, file: Path, shown: Path) -> Mistake:
    """A mistake that names its file, if this is not the shown one."""
    if file == shown:
        return mistake
    name = file.relative_to(shown.parent) if file.is_relative_to(shown.parent) else file
    return replace(mistake, message=f"{name.as_posix()}: {mistake.message}")


def _mistake_of(finding: Finding, lines: list[str]) -> Mistake:
    line, column = finding.location.line, finding.location.column
    message, hint = with_options(finding.message), with_options(finding.hint)
    severity = "error" if finding.severity == "error" else "warning"
    return Mistake(severity, message, hint, line, column, _code(lines, line, column))


def _mistake_of_derivation(error: DerivationError, lines: list[str]) -> Mistake:
    if error.location is None:
        return Mistake("error", error.message, error.hint)
    line, column = error.location.line, error.location.column
    return Mistake("error", error.message, error.hint, line, column, _code(lines, line, column))


def _code(lines: list[str], number: int, column: int) -> tuple[str, str]:
    """`Mistake.code` of a place, without indentation; ends of a long line that are far from it are cut."""
    if not 1 <= number <= len(lines):
        return "", ""
    line, place = lines[number - 1], max(column - 1, 0)
    before, behind = line[:place].lstrip(), line[place:]
    if len(before) > _MOST_CODE:
        before = f"…{before[-_MOST_CODE:]}"
    return before, behind if len(behind) <= _MOST_CODE else f"{behind[:_MOST_CODE]}…"
