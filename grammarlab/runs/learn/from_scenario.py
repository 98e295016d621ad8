"""From a scenario to a learned file on disk, with its divergence."""

from __future__ import annotations

import os
import shutil
import stat
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from grammarlab.asset_roots import AssetRoot, own_folder, place_of
from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.grammar_skeleton import MAX_EXAMINED_MODELS
from grammarlab.density.samples import sampled
from grammarlab.density.targets.rejection import Progress, silent
from grammarlab.density.targets.target import Target
from grammarlab.derivation.derive import derive
from grammarlab.errors import UsageError
from grammarlab.evaluation.preparation import Source
from grammarlab.evaluation.scenario import load as load_scenario
from grammarlab.files import atomic_file, whole_tree, write_text
from grammarlab.language.presets import NO_CHOICES, RuleChoices
from grammarlab.learning.designs.design_space import AbstractDesignSpace
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.species_space import SpeciesSpace
from grammarlab.learning.targets import known_score
from grammarlab.learning.targets.divergence import Measured
from grammarlab.learning.targets.file_head import origin_line
from grammarlab.learning.targets.grammar_target import METHODS, LearnedSampler, learn_target
from grammarlab.learning.targets.writers import Learned, check_method
from grammarlab.runs.learn.scenario_measures import LabelledSet
from grammarlab.runs.sample.checks import named_files
from grammarlab.runs.sample.domains import opened
from grammarlab.runs.sample.shipped import assets_folder, find_rules
from grammarlab.runs.sample.sources import load_source
from grammarlab.runs.work.workers import one_thread


@dataclass(frozen=True, slots=True)
class LearnResult:
    """A learned density and its comparison with the target."""

    learned: Learned[Any]
    source: Source
    file: Path | None
    """The new file; None if the method makes none."""
    measured: Measured
    """Comparison on the labelled set of the scenario."""
    seconds: float
    """Seconds from the preference to the text of the grammar."""

    @property
    def js(self) -> float:
        """Divergence from the target density, in nats."""
        return self.measured.after.js

    @property
    def js_before(self) -> float:
        """Divergence of the original grammar."""
        return self.measured.before.js


def learn_from_scenario(
    grammar: str,
    scenario: Path,
    method: str,
    file: Path,
    num_samples: int = sampled.NUM_SAMPLES,
    on_progress: Progress = silent,
    choices: RuleChoices = NO_CHOICES,
) -> LearnResult:
    """Learn a file that samples in proportion to a known preference, and measure it.

    Args:
        grammar: a file or the name of a shipped one: that of the scenario.
        scenario: a scenario file.
        method: name of a method, one of `METHODS`, or of `grammarlab.learning.targets.known_score.METHODS` for a
            species; empty for the first one.
        file: path of the new file; assets that it names are copied beside it.
        num_samples: number of models to learn from, for methods that need them.
        on_progress: called with the progress of these models.
        choices: choices of the user for a rule file; if there are none, those of the scenario.

    Raises:
        UsageError: If the method is unknown, or the scenario has another grammar.
        GrammarlabError: If the density cannot be made.
    """
    rules = find_rules(grammar, choices=load_scenario(scenario).choices if choices == NO_CHOICES else choices)
    space = opened(rules.suffix, rules.text(), rules.name, rules.assets)
    source = scenario_of(scenario, grammar, space.hashes[0])
    if isinstance(space, SpeciesSpace):
        return _species_of(source, space, method, file)
    method = method or METHODS[0]
    check_method(method, METHODS)
    learned, seconds = learned_of(source, method, num_samples, on_progress)
    if isinstance(learned, LearnedGrammar):
        write_learned(file, learned.text, GrammarSpace(learned.original, rules.assets), rules.assets)
    written = file if isinstance(learned, LearnedGrammar) else None
    return LearnResult(learned, source, written, LabelledSet.of(source).measure(learned), seconds)


def _species_of(source: Source, space: SpeciesSpace, method: str, file: Path) -> LearnResult:
    """The result for a species."""
    scenario = source.scenario
    check_method(method or known_score.METHODS[0], known_score.METHODS)
    if scenario.base == "uniform":
        raise UsageError(
            f"scenario {scenario.name}: trees of a species cannot all be equally likely; use the base grammar."
        )
    scenario.check(space)
    labelled = LabelledSet.of(source)
    begun = perf_counter()
    learned = known_score.species_of_score(space, scenario.score, labelled.batches, _lines(source))
    seconds = perf_counter() - begun
    write_learned(file, learned.text, space, space.assets or file.parent)
    return LearnResult(learned, source, file, labelled.measure(learned), seconds)


def learned_of(
    source: Source, method: str, num_samples: int = sampled.NUM_SAMPLES, on_progress: Progress = silent
) -> tuple[LearnedSampler, float]:
    """Result of a method for a scenario, and its seconds.

    Args:
        source: the scenario with its grammar.
        method: name of a method, one of `METHODS`.
        num_samples: number of models to learn from; they differ from those of the labelled set.
        on_progress: called with the progress of these models.

    Raises:
        GrammarlabError: If the density cannot be made.
    """
    scenario, space = source.scenario, source.grammar_space
    scenario.check(space)
    grammar, assets = space.grammar, space.assets
    forest = derive(grammar, MAX_EXAMINED_MODELS, scenario.seed, assets=assets, leaves=False)
    target = Target.of_score(grammar, scenario.score, scenario.base, assets)
    lines = _lines(source)
    begun = perf_counter()
    with one_thread():
        learned = learn_target(target, method, forest, lines, (scenario.seed + 1) % 2**64, num_samples, on_progress)
    return learned, perf_counter() - begun


def _lines(source: Source) -> list[str]:
    """Comment lines at the top of a file."""
    scenario = source.scenario
    return [
        origin_line(find_rules(scenario.grammar).file, source.space.hashes[0]),
        f"Scenario {scenario.name}: {scenario.title}",
    ]


def scenario_of(scenario: Path, name: str, text_hash: str) -> Source:
    """A scenario of a grammar.

    Args:
        scenario: a scenario file.
        name: name of the grammar as given by the user.
        text_hash: SHA-256 of its text.

    Raises:
        UsageError: If the scenario has another grammar.
    """
    source = load_source(scenario)
    if text_hash != source.space.hashes[0]:
        scenario_rules = source.scenario.grammar
        hint = ""
        if Path(scenario_rules).stem == Path(name).stem:
            hint = ": the texts differ, or their style, start rule, values of attributes or library"
        raise UsageError(f"scenario {source.scenario.name} is about {scenario_rules}, not about {name}{hint}")
    return source


def write_learned(file: Path, text: str, space: AbstractDesignSpace[Any], assets: AssetRoot) -> None:
    """Write a learned file, and copy the assets of the space beside it."""
    file.parent.mkdir(parents=True, exist_ok=True)
    write_text(file, text)
    put_assets_beside(file, space, assets)


def put_assets_beside(file: Path, space: AbstractDesignSpace[Any], assets: AssetRoot) -> None:
    """Copy the assets of a space to the asset folder of a file.

    Folders are copied whole, since rules may build names from parts. Existing files are kept.
    """
    own = own_folder(assets)
    if not own.is_dir() or assets_folder(file).resolve() == own.resolve():
        return
    folder = file.parent / "assets"
    for source, name in sorted({_copied(path, assets) for path in named_files(space.asset_names(), assets).values()}):
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if os.path.lexists(target):  # perhaps a link without a file, through which nothing is written
            continue
        if source.is_file():
            with atomic_file(target) as part:  # half a file would be kept by the next run
                shutil.copyfile(source, part)
        else:
            with whole_tree(target) as part:
                # Links stay links, so that no file from outside is copied.
                shutil.copytree(source, part, symlinks=True, ignore=_special)


def _copied(path: Path, assets: AssetRoot) -> tuple[Path, str]:
    """What is copied for an asset, and its name: its topmost folder, or its own folder in a library of many."""
    place = place_of(path, assets)
    name = Path(place.name)
    in_library = place.folder != own_folder(assets).resolve()
    name = name.parent if in_library else Path(name.parts[0])
    return place.folder / name, name.as_posix()


def _special(folder: str, names: list[str]) -> list[str]:
    """Pipes and devices in a folder, which cannot be copied."""
    modes = {name: Path(folder, name).lstat().st_mode for name in names}
    plain = (stat.S_ISREG, stat.S_ISDIR, stat.S_ISLNK)
    return [name for name, mode in modes.items() if not any(is_kind(mode) for is_kind in plain)]
