"""From a scenario to a learned grammar on disk, and how good it is."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from grammarlab import __version__
from grammarlab.density import sampled
from grammarlab.density.learned import LearnedGrammar
from grammarlab.density.skeleton import ENOUGH_MODELS
from grammarlab.density.target import Target
from grammarlab.density.thinning import Progress, silent
from grammarlab.derivation.derive import derive
from grammarlab.errors import UsageError
from grammarlab.evaluation.preparation import Source
from grammarlab.files import write_text
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax import String
from grammarlab.language.walking import walk
from grammarlab.learning.grammar_target import Learned, check_method, learn_target
from grammarlab.learning.measure import Measured
from grammarlab.runs.asset_files import named_files
from grammarlab.runs.evaluate.task import load_source
from grammarlab.runs.examples import assets_folder, find_rules
from grammarlab.runs.learn.measure import LabelledSet
from grammarlab.runs.workers import one_thread


@dataclass(frozen=True, slots=True)
class LearnResult:
    """A learned grammar and how good it is."""

    learned: Learned
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
    check_method(method)
    source = scenario_of(scenario, grammar, Grammar.parse(find_rules(grammar).text()))
    learned, seconds = learned_of(source, method, num_samples, on_progress)
    if isinstance(learned, LearnedGrammar):
        write_learned(file, learned, source.assets)
    written = file if isinstance(learned, LearnedGrammar) else None
    return LearnResult(learned, source, written, LabelledSet.of(source).measure(learned), seconds)


def learned_of(
    source: Source, method: str, num_samples: int = sampled.NUM_SAMPLES, on_progress: Progress = silent
) -> tuple[Learned, float]:
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
    lines = [origin_line(find_rules(found.grammar).name, grammar), f"Scenario {found.name}: {found.title}"]
    begun = perf_counter()
    with one_thread():
        learned = learn_target(target, method, forest, lines, (found.seed + 1) % 2**64, num_samples, on_progress)
    return learned, perf_counter() - begun


def origin_line(name: str, grammar: Grammar) -> str:
    """The line of a learned file that says what it was made from, which `grammarlab compare` reads."""
    return f"Learned by grammarlab {__version__} from {name}.cga (SHA-256 {grammar.hash[:16]})"


def scenario_of(scenario: Path, name: str, grammar: Grammar) -> Source:
    """A scenario about a grammar.

    Args:
        scenario: a scenario file.
        name: of the grammar, as the user gave it.
        grammar: the same, read.

    Raises:
        UsageError: when the scenario is about another one.
    """
    source = load_source(scenario)
    if grammar.hash != source.grammar.hash:
        raise UsageError(
            f"scenario {source.scenario.name} is about the grammar {source.scenario.grammar}, not about {name}"
        )
    return source


def write_learned(file: Path, learned: LearnedGrammar, assets: Path) -> None:
    """Writes the rule file of a learned grammar, and puts the assets that it needs beside it."""
    file.parent.mkdir(parents=True, exist_ok=True)
    write_text(file, learned.text)
    put_assets_beside(file, learned.original, assets)


def put_assets_beside(file: Path, grammar: Grammar, assets: Path) -> None:
    """Copies the assets that a grammar names to where a rule file at this place looks for them.

    Folders among them are copied whole, since rules may put names together. What is there already stays.
    """
    if not assets.is_dir() or assets_folder(file).resolve() == assets.resolve():
        return
    folder = file.parent / "assets"
    texts = (node.value for node in walk(grammar.tree) if isinstance(node, String))
    for top in sorted({Path(name).parts[0] for name in named_files(texts, assets)}):
        source, target = assets / top, folder / top
        folder.mkdir(exist_ok=True)
        if source.is_file() and not target.exists():
            shutil.copyfile(source, target)
        elif not target.exists():
            shutil.copytree(source, target, symlinks=True)  # as links, so that nothing from outside comes along
