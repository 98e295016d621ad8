"""Sample models from stochastic CGA shape grammars, and trees; score them, and learn a file that samples liked ones.

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
    from grammarlab.derivation.model_values import attribute, report
    from grammarlab.errors import GrammarlabError
    from grammarlab.export.save import SaveOptions, save
    from grammarlab.facade.editing.edit import edit as edit_facade
    from grammarlab.facade.file import load_facade, save_facade
    from grammarlab.facade.tree import Facade
    from grammarlab.features.columns.vocabulary import extract
    from grammarlab.features.named_features import count, pattern
    from grammarlab.geometry.footprints.footprint_text import read_footprints
    from grammarlab.language.grammar import Grammar
    from grammarlab.language.presets import RuleChoices
    from grammarlab.learning.fitting import fit
    from grammarlab.learning.learn import learn
    from grammarlab.learning.targets.writers import LearnedDensity
    from grammarlab.notebook import ScoringSession, view
    from grammarlab.preference.label_files import read_labels, save_labels
    from grammarlab.preference.labels import Label, Labels
    from grammarlab.preference.queries import Situation, propose
    from grammarlab.runs.facade.gallery import show_facade
    from grammarlab.runs.facade.grammar_file import grammar_of as facade_grammar
    from grammarlab.runs.facade.read import read_facade
    from grammarlab.runs.learn.from_labels import learn_from_labels
    from grammarlab.runs.sample.contact_sheet import render
    from grammarlab.runs.sample.request import SampleRequest
    from grammarlab.runs.sample.run import sample_run
    from grammarlab.runs.sample.shipped import examples_folder
    from grammarlab.runs.sample.sources import load
    from grammarlab.runs.work.executors import Processes
    from grammarlab.scene.instances import Scene, realize
    from grammarlab.trees.growth import grow
    from grammarlab.trees.measures import measure_trees
    from grammarlab.trees.scene import realize_trees
    from grammarlab.trees.skeleton import Skeleton
    from grammarlab.trees.species import Species
    from grammarlab.trees.species_file import parse as parse_species
    from grammarlab.trees.species_file import write as write_species

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
    "RuleChoices",
    "SampleRequest",
    "SaveOptions",
    "Scene",
    "ScoringSession",
    "Situation",
    "Skeleton",
    "Species",
    "attribute",
    "count",
    "derive",
    "edit_facade",
    "examples_folder",
    "extract",
    "facade_grammar",
    "fit",
    "grow",
    "learn",
    "learn_from_labels",
    "load",
    "load_facade",
    "measure_trees",
    "parse_species",
    "pattern",
    "propose",
    "read_facade",
    "read_footprints",
    "read_labels",
    "realize",
    "realize_trees",
    "render",
    "report",
    "sample",
    "sample_run",
    "save",
    "save_facade",
    "save_labels",
    "show_facade",
    "view",
    "write_species",
]

_HOMES = {
    "Facade": "facade.tree",
    "Forest": "derivation.forest",
    "Grammar": "language.grammar",
    "GrammarlabError": "errors",
    "Label": "preference.labels",
    "Labels": "preference.labels",
    "LearnedDensity": "learning.targets.writers",
    "Lots": "derivation.lots",
    "Processes": "runs.work.executors",
    "RuleChoices": "language.presets",
    "SampleRequest": "runs.sample.request",
    "SaveOptions": "export.save",
    "Scene": "scene.instances",
    "ScoringSession": "notebook",
    "Situation": "preference.queries",
    "Skeleton": "trees.skeleton",
    "Species": "trees.species",
    "attribute": "derivation.model_values",
    "count": "features.named_features",
    "derive": "derivation.derive",
    "edit_facade": "facade.editing.edit:edit",
    "examples_folder": "runs.sample.shipped",
    "extract": "features.columns.vocabulary",
    "facade_grammar": "runs.facade.grammar_file:grammar_of",
    "fit": "learning.fitting",
    "grow": "trees.growth",
    "learn": "learning.learn",
    "learn_from_labels": "runs.learn.from_labels",
    "load": "runs.sample.sources",
    "load_facade": "facade.file",
    "measure_trees": "trees.measures",
    "parse_species": "trees.species_file:parse",
    "pattern": "features.named_features",
    "propose": "preference.queries",
    "read_facade": "runs.facade.read",
    "read_footprints": "geometry.footprints.footprint_text",
    "read_labels": "preference.label_files",
    "realize": "scene.instances",
    "realize_trees": "trees.scene",
    "render": "runs.sample.contact_sheet",
    "report": "derivation.model_values",
    "sample": "density.sampler",
    "sample_run": "runs.sample.run",
    "save": "export.save",
    "save_facade": "facade.file",
    "save_labels": "preference.label_files",
    "show_facade": "runs.facade.gallery",
    "view": "notebook",
    "write_species": "trees.species_file:write",
}
"""Module of each public name, and its name in that module if it differs."""


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, name_in_module = _HOMES[name].partition(":")
    value = getattr(import_module(f"{__name__}.{module}"), name_in_module or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
