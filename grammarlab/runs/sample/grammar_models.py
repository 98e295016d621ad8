"""Rule files as a domain of runs: their models are derived, with saved derivations and summaries of reports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from grammarlab.asset_roots import AssetRoot
from grammarlab.derivation.derive import attributes_of_lots, derive
from grammarlab.derivation.forest import Forest
from grammarlab.errors import Finding, LanguageError
from grammarlab.features.accepted_grammar import AcceptedGrammar
from grammarlab.geometry.footprints.footprint import Remark
from grammarlab.language.attribute_values import AttributeValue, read_attributes
from grammarlab.language.grammar import Grammar, may_import, read_text
from grammarlab.language.reachability import likely_start, marks_start
from grammarlab.runs.sample.checks import check_rules, grammar_to_run, unsupported_features
from grammarlab.runs.sample.domains import AbstractDomain, CheckedText
from grammarlab.runs.sample.models import (
    EMPTY_MODELS,
    AbstractModels,
    Batch,
    MadeModels,
    MadeScene,
    lots_of,
    property_remarks,
)
from grammarlab.runs.sample.shipped import SUFFIX
from grammarlab.scene import Scene, realize

if TYPE_CHECKING:
    from grammarlab.learning.designs.grammar_space import GrammarSpace
    from grammarlab.learning.targets.grammar_target import GrammarWriter
    from grammarlab.runs.sample.model_rows import ModelRows
    from grammarlab.runs.sample.request import SampleRequest

Summary: TypeAlias = dict[str, float | int | None]
"""``count``, and ``sum``, ``mean``, ``min`` and ``max``: None if reported values are not finite numbers."""


@dataclass(frozen=True)
class GrammarModels(AbstractModels):
    """Models derived from a grammar."""

    source: AcceptedGrammar

    def attributes(self, texts: Sequence[str]) -> dict[str, AttributeValue]:
        return read_attributes(texts, self.source.grammar)

    def left_out(self) -> tuple[Finding, ...]:
        return unsupported_features(self.source.grammar)

    def check(self, request: SampleRequest) -> None:
        attributes, start_rule = request.attributes, request.start_rule or None
        derive(self.source.program, 0, request.seed, attributes=attributes, start_rule=start_rule)

    def asset_names(self) -> Iterable[str]:
        return self.source.asset_names()

    def remarks(self, request: SampleRequest) -> tuple[Remark, ...]:
        return tuple(
            remark for footprint in request.footprints for remark in property_remarks(footprint, self.source.grammar)
        )

    def make(self, request: SampleRequest, batch: Batch) -> MadeModels:
        accepted = self.source.derive(lots_of(request, batch, self.source.grammar))
        forest = accepted.forest

        def save(folder: Path) -> Iterable[str]:
            # Derivations are tables of Arrow, which a grammar is read without.
            from grammarlab.runs.sample.derivations import FILES, save_forest  # noqa: PLC0415

            save_forest(forest, folder)
            return FILES

        return MadeModels(
            scenes=[
                MadeScene(
                    scene=realize(forest),
                    shapes=forest.shapes_per_model().tolist(),
                    reports=summarize_reports(forest),
                )
            ],
            log_probability=forest.log_probability().tolist(),
            prints=forest.prints,
            missing_assets=forest.missing_assets,
            warnings=(*forest.warnings, *_of_start(request, forest, self.source)),
            tries=accepted.tries.tolist(),
            accepted=accepted.is_accepted.tolist(),
            save=save,
        )

    def rows(self, request: SampleRequest, batch: Batch) -> ModelRows:
        from grammarlab.runs.sample.model_rows import forest_rows  # noqa: PLC0415

        accepted = self.source.derive(lots_of(request, batch, self.source.grammar))
        return forest_rows(accepted.forest, accepted.tries, accepted.is_accepted)

    def legend(self) -> dict[str, Any]:
        return {"sites": [asdict(site) for site in self.source.program.sites]}

    def stored(self, request: SampleRequest, batch: Batch, folder: Path) -> Iterator[Scene]:
        from grammarlab.runs.sample.derivations import load_forest  # noqa: PLC0415

        forest = load_forest(folder)
        if self.source.acceptance is None:  # with a rule, lots say nothing of the draws of accepted candidates
            attributes = attributes_of_lots(self.source.program, forest.lots, self.source.folder)
            forest = replace(forest, attributes=attributes)
        yield realize(forest)


class GrammarDomain(AbstractDomain["GrammarSpace", GrammarModels]):
    """Domain of rule files."""

    def read(self, path: Path, library: Path | str | None = None) -> str:
        """Text of the file merged with its imports; the file's own text if it has syntax errors."""
        text = read_text(path)
        if not may_import(text):
            return text
        from grammarlab.language.importing import load  # noqa: PLC0415
        from grammarlab.language.linking import linked  # noqa: PLC0415

        try:
            return linked(load(path, library=library))
        except LanguageError as error:
            if any(finding.code == "bad-import" for finding in error.findings):
                raise
            return text

    def check(self, path: Path, assets: AssetRoot) -> Sequence[CheckedText]:
        return check_rules(path, assets)

    def formatted(self, text: str, file: str, suffix: str) -> str:
        if suffix != SUFFIX:
            return super().formatted(text, file, suffix)
        from grammarlab.language.formatting import format_grammar  # noqa: PLC0415  # drawing does not need it

        return format_grammar(Grammar.parse(text, file))

    def open(self, text: str, name: str, assets: AssetRoot) -> GrammarSpace:
        from grammarlab.learning.designs.grammar_space import GrammarSpace  # noqa: PLC0415

        space = GrammarSpace(grammar_to_run(text, f"{name}{SUFFIX}"), assets)
        _ = space.program  # a grammar that cannot be compiled is an error of the text
        return space

    def models(self, text: str, name: str, assets: AssetRoot) -> GrammarModels:
        source = AcceptedGrammar(grammar_to_run(text, f"{name}{SUFFIX}"), assets)
        _ = source.program
        return GrammarModels(source)

    def writer(self, space: GrammarSpace) -> GrammarWriter:
        # It loads JAX, which drawing does not need.
        from grammarlab.learning.targets.grammar_target import GrammarWriter  # noqa: PLC0415

        return GrammarWriter(space)


def _of_start(request: SampleRequest, forest: Forest, source: AcceptedGrammar) -> tuple[Finding, ...]:
    """A warning if the models are empty and nobody chose the rule that they begin with."""
    grammar, start = source.grammar, source.program.default_start
    if len(forest.leaves) or request.start_rule or not start or marks_start(grammar.tree):
        return ()
    likely = likely_start(grammar.tree)
    advice = f"; `start_rule={likely}` may be meant" if likely not in ("", start) else ""
    message = f"models have no shape: no rule is marked @StartRule, so they begin with {start}{advice}"
    return (Finding("warning", EMPTY_MODELS, message, grammar.rules[start, 0].location),)


def summarize_reports(forest: Forest) -> list[dict[str, Summary]]:
    """Summaries of the values of each key of each model, keys in alphabetical order."""
    summaries: list[dict[str, Summary]] = [{} for _ in range(forest.num_models)]
    reports = forest.reports
    model, is_in_statistics = forest.nodes.model[reports.node].astype(np.int64), forest.is_in_statistics()
    order = np.lexsort((reports.key, model))
    groups, starts = np.unique((model * max(len(reports.keys), 1) + reports.key)[order], return_index=True)
    for group, rows in zip(groups.tolist(), np.split(order, starts[1:]), strict=False):
        key = reports.keys[group % len(reports.keys)]
        numbers = reports.value[rows][is_in_statistics[rows]]
        summaries[group // len(reports.keys)][key] = _summary(len(rows), numbers)
    return summaries


def _summary(count: int, values: np.ndarray) -> Summary:
    total = float(values.sum())
    if not np.isfinite(total):
        return {"count": count, "sum": None, "mean": None, "min": None, "max": None}
    return {
        "count": count,
        "sum": total,
        "mean": total / len(values),
        "min": float(values.min()),
        "max": float(values.max()),
    }
