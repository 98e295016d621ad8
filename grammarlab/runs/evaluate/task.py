"""One learning curve: what to make, and making it. Runs in any process."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from grammarlab import __version__
from grammarlab.evaluation import protocol
from grammarlab.evaluation.curves import Curve
from grammarlab.evaluation.learners import learner_of
from grammarlab.evaluation.material import Columns, Material
from grammarlab.evaluation.methods import Method
from grammarlab.evaluation.preparation import Source, prepare
from grammarlab.evaluation.scenario import load
from grammarlab.runs.derive_batch import compiled
from grammarlab.runs.evaluate.cache import keep_in
from grammarlab.runs.evaluate.measurements import digest
from grammarlab.runs.evaluate.store import CurveRecord
from grammarlab.runs.examples import find_rules


@dataclass(frozen=True, slots=True)
class Task:
    """One curve to make."""

    scenario: Path
    """The scenario file."""
    source_key: str
    """`Source.key`: what the scenario and its grammar say."""
    method: Method
    seed: int
    """0 <= seed < 2**64."""
    max_labels: int
    """>= 1."""
    cache: Path
    """Folder for features that other curves and other runs use again."""

    @property
    def key(self) -> str:
        """Names the curve: SHA-256 of everything that decides it but `max_labels`."""
        values = [__version__, self.source_key, self.method.as_json(), self.seed]
        return digest(values)

    @property
    def place(self) -> str:
        """Names the curve among all that are made."""
        return f"{self.key}-{self.max_labels}"

    def __str__(self) -> str:
        return f"the curve of {self.scenario.stem}, method {self.method.name}, seed {self.seed}"


def load_source(scenario: Path) -> Source:
    """A scenario file with its grammar.

    Raises:
        GrammarlabError: as the files give reason to.
    """
    found = load(scenario)
    rules = find_rules(found.grammar)
    grammar, _ = compiled(rules.text(), rules.name)
    return Source(found, grammar, rules.assets)


@lru_cache(maxsize=2)
def load_material(scenario: Path, _source_key: str, families: tuple[str, ...], cache: Path) -> Material:
    """What the curves of a scenario are made from; the tasks of one scenario stand together, so few are kept.

    The key is there so that a file that has changed is read again.
    """
    return prepare(replace(load_source(scenario), families=families), keep_in(cache))


def material_of(task: Task) -> Material:
    """What the curve of a task is made from."""
    return load_material(task.scenario, task.source_key, task.method.families, task.cache)


def prepare_material(task: Task) -> None:
    """Fill the cache with what the first round of a task needs."""
    length = task.method.path_length or _source_of(task).feature_options.path_length
    material_of(task).table(Columns(length))


def run_protocol(task: Task) -> tuple[Material, protocol.State, Curve]:
    """The simulated person of a task, after all rounds."""
    material = material_of(task)
    material = material if task.method.factored else material.as_one_factor()
    learner = learner_of(task.method, _source_of(task).feature_options)
    state, curve = protocol.run(material, learner, task.seed, task.max_labels)
    return material, state, curve


def make_curve(task: Task) -> CurveRecord:
    """The curve of a task."""
    material, _, curve = run_protocol(task)
    name = load_source(task.scenario).scenario.name
    return CurveRecord(task.key, name, task.method.name, task.seed, task.max_labels, material.js_original, curve)


def _source_of(task: Task) -> Source:
    return replace(load_source(task.scenario), families=task.method.families)
