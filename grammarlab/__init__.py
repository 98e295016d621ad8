"""Sample models from stochastic CGA shape grammars, score them, and learn a grammar that samples liked models.

The names in ``__all__`` are public; all other names may change with any release. They are imported when they are first
used, so that importing the package loads nothing.

>>> import grammarlab as gl
>>> grammar = gl.Grammar.parse("Lot --> s(5, 0, 5) extrude(rand(3, 30)) Tower")
>>> forest = gl.derive(grammar, 100, seed=1)
>>> scene = gl.realize(forest)
>>> picture = gl.render(gl.realize(gl.derive(grammar, 4, seed=1)), pixels=40)
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from grammarlab.about import __version__ as __version__

if TYPE_CHECKING:
    from grammarlab.density.sampler import sample
    from grammarlab.derivation.derive import derive
    from grammarlab.derivation.forest import Forest
    from grammarlab.derivation.lots import Lots
    from grammarlab.errors import GrammarlabError
    from grammarlab.export.save import SaveOptions, save
    from grammarlab.facade.file import load_facade, save_facade
    from grammarlab.facade.tree import Facade
    from grammarlab.features.columns.vocabulary import extract
    from grammarlab.features.counting.named import count
    from grammarlab.features.patterns.text import parse as pattern
    from grammarlab.geometry.outlines.footprints import read_footprints
    from grammarlab.language.grammar import Grammar
    from grammarlab.learning.learn import learn
    from grammarlab.learning.targets.target import LearnedDensity
    from grammarlab.notebook import ScoringSession
    from grammarlab.preference.fitting import fit
    from grammarlab.preference.labels.files import read_labels, save_labels
    from grammarlab.preference.labels.table import Label, Labels
    from grammarlab.preference.questions.queries import Situation, propose
    from grammarlab.runs.facade.edit import edit as edit_facade
    from grammarlab.runs.facade.grammar import grammar_of as facade_grammar
    from grammarlab.runs.facade.read import read_facade
    from grammarlab.runs.facade.show import show_facade
    from grammarlab.runs.learn.labels import learn_from_labels
    from grammarlab.runs.pictures.render import render
    from grammarlab.runs.requests.examples import examples_folder
    from grammarlab.runs.requests.loading import load
    from grammarlab.runs.requests.request import SampleRequest
    from grammarlab.runs.sampling.sample import sample_run
    from grammarlab.runs.work.executors import Processes
    from grammarlab.scene.instances import Scene, realize

__all__ = [
    "Facade",
    "Forest",
    "Grammar",
    "GrammarlabError",
    "Label",
    "Labels",
    "LearnedDensity",
    "Lots",
    "Processes",
    "SampleRequest",
    "SaveOptions",
    "Scene",
    "ScoringSession",
    "Situation",
    "count",
    "derive",
    "edit_facade",
    "examples_folder",
    "extract",
    "facade_grammar",
    "fit",
    "learn",
    "learn_from_labels",
    "load",
    "load_facade",
    "pattern",
    "propose",
    "read_facade",
    "read_footprints",
    "read_labels",
    "realize",
    "render",
    "sample",
    "sample_run",
    "save",
    "save_facade",
    "save_labels",
    "show_facade",
]

_HOMES = {
    "Facade": "facade.tree",
    "Forest": "derivation.forest",
    "Grammar": "language.grammar",
    "GrammarlabError": "errors",
    "Label": "preference.labels.table",
    "Labels": "preference.labels.table",
    "LearnedDensity": "learning.targets.target",
    "Lots": "derivation.lots",
    "Processes": "runs.work.executors",
    "SampleRequest": "runs.requests.request",
    "SaveOptions": "export.save",
    "Scene": "scene.instances",
    "ScoringSession": "notebook",
    "Situation": "preference.questions.queries",
    "count": "features.counting.named",
    "derive": "derivation.derive",
    "edit_facade": "runs.facade.edit:edit",
    "examples_folder": "runs.requests.examples",
    "extract": "features.columns.vocabulary",
    "facade_grammar": "runs.facade.grammar:grammar_of",
    "fit": "preference.fitting",
    "learn": "learning.learn",
    "learn_from_labels": "runs.learn.labels",
    "load": "runs.requests.loading",
    "load_facade": "facade.file",
    "pattern": "features.patterns.text:parse",
    "propose": "preference.questions.queries",
    "read_facade": "runs.facade.read",
    "read_footprints": "geometry.outlines.footprints",
    "read_labels": "preference.labels.files",
    "realize": "scene.instances",
    "render": "runs.pictures.render",
    "sample": "density.sampler",
    "sample_run": "runs.sampling.sample",
    "save": "export.save",
    "save_facade": "facade.file",
    "save_labels": "preference.labels.files",
    "show_facade": "runs.facade.show",
}
"""Module of each public name, and its name in that module if it differs."""


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, own = _HOMES[name].partition(":")
    found = getattr(import_module(f"{__name__}.{module}"), own or name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
