"""From labels to a learned grammar on disk: fit, simplify, compile, and measure the change by each step."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from grammarlab.density.targets.rejection import Progress, silent
from grammarlab.errors import check_type
from grammarlab.evaluation.respondents import EXACT, Respondent
from grammarlab.language.presets import NO_CHOICES, RuleChoices
from grammarlab.learning.answers import answers_of
from grammarlab.learning.designs.addresses import renamed
from grammarlab.learning.designs.design_space import AbstractDesignSpace
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.progress_line import LAST_REPORT, WRITING
from grammarlab.learning.round import Study, init, step
from grammarlab.learning.settings import Settings
from grammarlab.learning.stopping import expected_gain
from grammarlab.learning.targets.file_head import origin_line
from grammarlab.learning.targets.simplification import SimplifiedFactor
from grammarlab.learning.targets.writers import Learned, LearnedDensity, Making
from grammarlab.preference.base import Relevance
from grammarlab.preference.labels import Labels
from grammarlab.runs.learn.from_scenario import scenario_of, write_learned
from grammarlab.runs.learn.scenario_measures import TrueDensity
from grammarlab.runs.sample.domains import domain_of, opened
from grammarlab.runs.sample.shipped import RuleSource, find_rules
from grammarlab.runs.work.workers import one_thread


@dataclass(frozen=True)
class LabelsResult:
    """A file learned from labels, with the learned density."""

    space: AbstractDesignSpace[Any]
    """The space of the labelled designs."""
    density: LearnedDensity[Any]
    """The learned density."""
    file: Path | None
    """The new file; None if the method makes none."""
    labels_from: str
    """Name of the label file."""
    source: RuleSource
    num_labels: int
    left_out: tuple[str, ...]
    """Factors without a score above 0, whose preference is unknown."""
    seconds: float
    """Seconds from the labels to the text of the grammar."""
    notes: tuple[str, ...] = ()
    """What was understood of the label file, see `Labels.notes`."""
    gain: float | None = None
    """Expected gain of 16 more scores in nats; None if the method cannot estimate it."""
    truth: TrueDensity | None = None
    """Comparison with the true preference of a simulated person, if it is known."""

    @property
    def learned(self) -> Learned[Any]:
        """The sampler of the density."""
        return self.density.learned

    @property
    def factors(self) -> tuple[SimplifiedFactor, ...]:
        """The liked factors."""
        return self.density.predicted.factors

    @property
    def relevances(self) -> tuple[Relevance, ...]:
        """Relevance of groups of features, most relevant first; several factors have their names."""
        several = len(self.factors) > 1
        entries = [
            Relevance(f"{factor.name}: {entry.name}" if several else entry.name, entry.share, entry.level)
            for factor in self.factors
            for entry in factor.relevances
            if entry.level != "none"
        ]
        return tuple(sorted(entries, key=lambda entry: -entry.share))


def learn_from_labels(
    grammar: str,
    labels: Labels,
    file: Path | str,
    making: Making | None = None,
    *,
    labels_from: str,
    choices: RuleChoices = NO_CHOICES,
    settings: Settings | None = None,
    pool: Pool | None = None,
    seed: int = 0,
    scenario: Path | None = None,
    respondent: Respondent = EXACT,
    on_progress: Progress = silent,
) -> LabelsResult:
    """Learn a file that samples in proportion to scores.

    Args:
        grammar: a file that describes designs, or the name of a shipped grammar: that of the labels.
        labels: the labels.
        file: path of the new file, of the same kind; assets that it names are copied beside it.
        making: options of making it.
        labels_from: name of the label file, for a comment in the new file.
        choices: choices of the user for a rule file: those of the labels.
        settings: settings of learning; by default as in a session.
        pool: the pool of models; by default the usual one of the seed.
        seed: seed of the usual pool, 0 <= seed < 2**64.
        scenario: a scenario file to compare the result with; nothing is learned from it.
        respondent: respondent whose scale is used for this comparison; nothing is learned from it.
        on_progress: called with the name of a stage, how many of its parts are done, and how many there are (0 if
            unknown).

    Raises:
        UsageError: If labels are of another grammar, or nothing is liked.
        GrammarlabError: If the density cannot be made.

    >>> import grammarlab as gl
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> grammar = gl.Grammar.parse("Lot --> 50% : extrude(3) Low else : extrude(9) High")
    >>> high = gl.count(gl.derive(grammar, 24, seed=0), [gl.pattern("High")])[:, 0]
    >>> labels = gl.Labels(tuple(gl.Label(0, m, "overall", 100.0 * high[m], grammar.hash) for m in range(24)))
    >>> with TemporaryDirectory() as folder:
    ...     rules = Path(folder) / "tower.cga"
    ...     _ = rules.write_text(grammar.text)
    ...     found = gl.learn_from_labels(str(rules), labels, Path(folder) / "high.cga", labels_from="labels.csv")
    >>> found.learned.rules_after <= 2
    True
    """
    check_type("labels", labels, Labels, 'gl.read_labels("labels.csv")')
    begun, making, file = perf_counter(), making or Making(), Path(file)
    source = find_rules(grammar, choices=choices)
    text = source.text()
    space = opened(source.suffix, text, source.name, source.assets)
    writer = domain_of(source.suffix).writer(space)
    writer.method(making.method)
    true_source = None if scenario is None else scenario_of(scenario, grammar, space.hashes[0])
    answers = answers_of(renamed(labels, text), space.hashes)
    study = Study(space, pool or Pool.usual(space, seed), settings)
    lines = [origin_line(source.file, space.hashes[0]), f"Labels {labels_from}: {len(labels)} scores"]
    with one_thread():
        state = step(study, init(study), answers, on_progress)
        on_progress(WRITING, 0, 0)
        density = writer.learn(study, state, making, lines, on_progress)
        gain = expected_gain(study, state)
    seconds = perf_counter() - begun
    learned = density.learned
    on_progress(*LAST_REPORT)
    if learned.text:
        write_learned(file, learned.text, space, source.assets)
    return LabelsResult(
        space=space,
        density=density,
        file=file if learned.text else None,
        labels_from=labels_from,
        source=source,
        num_labels=len(labels),
        left_out=tuple(factor_answers.factor for factor_answers in answers if not factor_answers.is_liked),
        seconds=seconds,
        notes=labels.notes,
        gain=gain,
        truth=None if true_source is None else TrueDensity.of(true_source, learned, respondent),
    )
