"""From a scenario to a learned grammar on disk, and how good it is."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from grammarlab.about import __version__
from grammarlab.density.samples import sampled
from grammarlab.density.skeleton import ENOUGH_MODELS
from grammarlab.density.splits.learned import LearnedGrammar
from grammarlab.density.targets.target import Target
from grammarlab.density.targets.thinning import Progress, silent
from grammarlab.derivation.derive import derive
from grammarlab.errors import UsageError
from grammarlab.evaluation.preparation import Source
from grammarlab.files import write_text
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.design_space import AbstractDesignSpace
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.targets.grammar_target import METHODS, LearnedSampler, learn_target
from grammarlab.learning.targets.measure import Measured
from grammarlab.learning.targets.target import check_method
from grammarlab.runs.learn.measure import LabelledSet
from grammarlab.runs.requests.asset_files import named_files
from grammarlab.runs.requests.examples import assets_folder, find_rules
from grammarlab.runs.sampling.sources import load_source
from grammarlab.runs.work.workers import one_thread


@dataclass(frozen=True, slots=True)
class LearnResult:
    """A learned grammar and how good it is."""

    learned: LearnedSampler
    source: Source
    file: Path | None
    """The new rule file; None where the method makes no grammar."""
    measured: Measured
    """On the labelled set of the scenario."""
    seconds: float
    """From the preference to the text of the grammar."""

    @property
    def js(self) -> float:
        """Divergence from the wanted density, in nats."""
        return self.measured.after.js

    @property
    def js_before(self) -> float:
        """That of the grammar as it was."""
        return self.measured.before.js


def learn_from_scenario(
    grammar: str,
    scenario: Path,
    method: str,
    file: Path,
    num_samples: int = sampled.NUM_SAMPLES,
    on_progress: Progress = silent,
) -> LearnResult:
    """Learns the grammar that samples in proportion to a known preference, and measures it.

    Args:
        grammar: a rule file or the name of a shipped grammar: that of the scenario.
        scenario: a scenario file.
        method: of `METHODS`.
        file: where to write the new rule file; assets that it names are put beside it.
        num_samples: models to learn from, for the methods that need them.
        on_progress: told about these models.

    Raises:
        UsageError: for an unknown method, or a grammar that the scenario is not about.
        GrammarlabError: when the density cannot be made.
    """
    check_method(method, METHODS)
    source = scenario_of(scenario, grammar, Grammar.parse(find_rules(grammar).text()).hash)
    learned, seconds = learned_of(source, method, num_samples, on_progress)
    if isinstance(learned, LearnedGrammar):
        write_learned(file, learned.text, GrammarSpace(learned.original, source.assets), source.assets)
    written = file if isinstance(learned, LearnedGrammar) else None
    return LearnResult(learned, source, written, LabelledSet.of(source).measure(learned), seconds)


def learned_of(
    source: Source, method: str, num_samples: int = sampled.NUM_SAMPLES, on_progress: Progress = silent
) -> tuple[LearnedSampler, float]:
    """What a method makes of a scenario, and how many seconds it took.

    Args:
        source: the scenario with its grammar.
        method: of `METHODS`.
        num_samples: models to learn from; others than those of the labelled set.
        on_progress: told about these models.

    Raises:
        GrammarlabError: when the density cannot be made.
    """
    grammar, found = source.grammar, source.scenario
    forest = derive(grammar, ENOUGH_MODELS, found.seed, assets=source.assets)
    found.check(forest.symbols, forest.rules, forest.sites)
    target = Target.of_score(grammar, found.score, found.base, source.assets)
    lines = [origin_line(find_rules(found.grammar).file, grammar.hash), f"Scenario {found.name}: {found.title}"]
    begun = perf_counter()
    with one_thread():
        learned = learn_target(target, method, forest, lines, (found.seed + 1) % 2**64, num_samples, on_progress)
    return learned, perf_counter() - begun


def origin_line(file: str, text_hash: str) -> str:
    """The line of a learned file that says what it was made from, which `grammarlab compare` reads."""
    return f"Learned by grammarlab {__version__} from {file} (SHA-256 {text_hash[:16]})"


def scenario_of(scenario: Path, name: str, text_hash: str) -> Source:
    """A scenario about a grammar.

    Args:
        scenario: a scenario file.
        name: of the grammar, as the user gave it.
        text_hash: SHA-256 of its text.

    Raises:
        UsageError: when the scenario is about another one.
    """
    source = load_source(scenario)
    if text_hash != source.grammar.hash:
        raise UsageError(
            f"scenario {source.scenario.name} is about the grammar {source.scenario.grammar}, not about {name}"
        )
    return source


def write_learned(file: Path, text: str, space: AbstractDesignSpace[Any], assets: Path) -> None:
    """Writes a learned file, and puts the assets that the space names beside it."""
    file.parent.mkdir(parents=True, exist_ok=True)
    write_text(file, text)
    put_assets_beside(file, space, assets)


def put_assets_beside(file: Path, space: AbstractDesignSpace[Any], assets: Path) -> None:
    """Copies the assets that a space names to where a file at this place looks for them.

    Folders among them are copied whole, since rules may put names together. What is there already stays.
    """
    if not assets.is_dir() or assets_folder(file).resolve() == assets.resolve():
        return
    folder = file.parent / "assets"
    for top in sorted({Path(name).parts[0] for name in named_files(space.asset_names(), assets)}):
        source, target = assets / top, folder / top
        folder.mkdir(exist_ok=True)
        if source.is_file() and not target.exists():
            shutil.copyfile(source, target)
        elif not target.exists():
            shutil.copytree(source, target, symlinks=True)  # as links, so that nothing from outside comes along
