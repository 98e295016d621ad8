"""Whether learning is ever worse than not learning: sessions of random grammars, tastes, persons and numbers of scores.

``python benchmarks/measure_law.py 200`` prints a line per session and how many learned densities are farther from the
person's own than 1.05 times the original one. Half of the sessions are interviews with default questions, half are one
step on random designs. ``--json FILE`` writes all sessions, and ``--first 100`` leaves out the first hundred.
Another learner is measured on the same sessions by running this script with ``PYTHONPATH`` set to its checkout.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from grammarlab.evaluation.methods import METHODS
from grammarlab.evaluation.preparation import Material, prepare
from grammarlab.evaluation.protocol import learned
from grammarlab.evaluation.respondents import RESPONDENTS
from grammarlab.learning.answers import Answers
from grammarlab.learning.interview import interview
from grammarlab.learning.round import State, init, step
from grammarlab.learning.targets.divergence import agreement
from grammarlab.runs.sample.sources import load_source

WORSE = 1.05
"""Ratio to the divergence of the original grammar above which learning did harm."""
MAX_SCORES = 64
"""Largest number of scores of a session."""
NUM_MODELS = 1000
"""Size of the pool, and of the labelled set."""
PERSONS = ("exact", "stars", "sd10", "blunders10", "sd20")
MIN_LIKED = 0.02
"""Least effective share of liked designs: a taste that the labelled set hardly shows has no measurable divergence."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Session:
    """One person with one grammar."""

    number: int
    taste: str
    person: str
    scores: int
    """Number of scores, 1 to 64."""
    asked: bool
    """Whether questions were chosen by the learner."""
    original: float
    """Divergence of the original grammar from the target, nats."""
    js: float
    """Divergence of the learned density from the target, nats."""

    @property
    def ratio(self) -> float:
        """The second as a multiple of the first."""
        return self.js / self.original

    def __str__(self) -> str:
        how = "questions" if self.asked else "random"
        return (
            f"{self.number:4} {self.person:10} {self.scores:3} {how:9} {self.original:.3f} -> {self.js:.4f}  "
            f"{self.ratio:5.2f}  {self.taste}"
        )


def grammar(randomness: np.random.Generator) -> tuple[str, list[int]]:
    """The text of a random grammar, and the number of alternatives of each of its choices.

    Parts ``P0``, ``P1`` ... are chosen independently; ``Unit`` is chosen in each of 2 to 6 places; ``$low`` and
    ``$high`` are drawn.
    """
    sizes = randomness.integers(2, 5, randomness.integers(3, 8)).tolist()
    parts = " ".join(f"P{index}" for index in range(len(sizes)))
    lines = [
        'version "2023.0"',
        "attr low = rand(2, 9)",
        "attr high = rand(3, 12)",
        "attr front = rand(4, 13)",
        "@StartRule",
        f"Lot --> s(front, high, low) Row {parts}",
        "Row --> split(x) { ~2 : Unit }*",
        rule("Unit", 3, randomness),
    ]
    return "\n".join((*lines, *(rule(f"P{index}", size, randomness) for index, size in enumerate(sizes)))), sizes


def rule(name: str, size: int, randomness: np.random.Generator) -> str:
    """A rule with alternatives of random probability."""
    shares = np.maximum((100.0 * randomness.dirichlet(np.full(size, 3.0))).astype(np.int64), 5)[:-1]
    listed = " ".join(f"{share}% : {name}{index}." for index, share in enumerate(shares.tolist()))
    return f"{name} --> {listed} else : {name}{size - 1}."


def taste(sizes: Sequence[int], randomness: np.random.Generator) -> str:
    """A random score of 0 to 100, as an expression."""
    order = randomness.permutation(len(sizes)).tolist()
    flags = [f"{{P{part}:{randomness.integers(sizes[part])}}}" for part in order]
    some = flags[: randomness.integers(2, len(flags) + 1)]
    points = np.round(100.0 * randomness.dirichlet(np.full(len(some), 2.0))).astype(np.int64).tolist()
    total = " + ".join(some)
    middle, unit = round(float(randomness.uniform(3.0, 8.0)), 1), f"{{Unit:{randomness.integers(3)}}}"
    low = int(randomness.integers(5, 40))
    kinds = (
        f"choose({' and '.join(some[:3])}, 100, 0)",
        f"choose({' and '.join(some[:2])}, 90, {flags[-1]}, {low}, 0)",
        " + ".join(f"{point} * {flag}" for point, flag in zip(points, some, strict=True)),
        f"choose({some[0]} != {some[1]}, 80, {low})",
        f"choose({total} >= {randomness.integers(1, len(some) + 1)}, 100, 0)",
        f"choose({total} == 1, 100, 0)",
        f"choose({' or '.join(some)}, 0, 60)",
        f"100 * exp(-($low - {middle}) * ($low - {middle}) / 2)",
        f"choose($low < $high, 100, {low})",
        f"{low} * {unit} / {{Unit}} * (1 + {some[0]})",
        f"choose({unit} >= 2, 100, 0)",
        f"{low} * (({total}) / {len(some)}) * (({total}) / {len(some)})",
        f"100 * choose({some[0]}, 1, 0.4) * choose({some[1]}, 1, 0.3) * choose({flags[-1]}, 1, 0.6)",
    )
    return kinds[int(randomness.integers(len(kinds)))]


def session(number: int, num_models: int = NUM_MODELS) -> Session:
    """A session by its number; of tastes that nearly all or hardly any design meets, another one is drawn.

    Args:
        number: seed of the session, >= 0.
        num_models: size of the pool and of the labelled set.
    """
    randomness = np.random.default_rng([number, 37])
    with tempfile.TemporaryDirectory() as folder:
        while True:
            text, sizes = grammar(randomness)
            wanted = taste(sizes, randomness)
            Path(folder, "any.cga").write_text(text)
            path = Path(folder, "any.toml")
            path.write_text(
                f'name = "any"\ntitle = "Any"\ngrammar = "any.cga"\npreference = "{wanted}"\n'
                f"num_models = {num_models}\nseed = {number}\n"
            )
            source = load_source(path)
            material = prepare(source, METHODS["default"].settings(source.scenario.features))
            weights = material.target
            liked = weights.sum() ** 2 / max(float((weights**2).sum()), 1e-300) / len(weights)
            if liked > MIN_LIKED and material.js_original > MIN_LIKED:
                break
    person = PERSONS[int(randomness.integers(len(PERSONS)))]
    num_scores, asked = int(randomness.integers(1, MAX_SCORES + 1)), number % 2 == 0
    answered = material.answered_by(RESPONDENTS[person], number)
    state = after(answered, num_scores, number, asked=asked)
    js = agreement(answered.target, learned(answered, state), answered.weights).js
    return Session(
        number=number,
        taste=wanted,
        person=person,
        scores=num_scores,
        asked=asked,
        original=answered.js_original,
        js=js,
    )


def after(material: Material, num_scores: int, seed: int, *, asked: bool) -> State:
    """The state after scores of chosen or random designs."""
    if asked:
        *_, last = interview(material.study, material.factors, material.person, budget=num_scores, seed=seed)
        return last
    pool = list(material.study.pool)
    chosen = np.random.default_rng(seed).permutation(len(pool))[:num_scores]
    designs = tuple(sorted(pool[index] for index in chosen.tolist()))
    scores = material.person(designs, np.arange(num_scores))[:, 0]
    return step(material.study, init(material.study), (Answers(material.factors[0], designs, scores),))


def main() -> None:
    parser = argparse.ArgumentParser(description="Whether learning is ever worse than not learning.")
    parser.add_argument("sessions", type=int, nargs="?", default=200, help="number of sessions (200)")
    parser.add_argument("--first", type=int, default=0, help="number of the first session (0)")
    parser.add_argument("--json", type=Path, help="file for all sessions")
    options = parser.parse_args()
    sessions = list[Session]()
    with threadpool_limits(1):
        for number in range(options.first, options.first + options.sessions):
            sessions.append(session(number))
            print(sessions[-1], flush=True)
            if options.json:
                options.json.write_text(json.dumps([asdict(each) for each in sessions], indent=1))
    print("\n" + summary(sessions))


def summary(sessions: Sequence[Session]) -> str:
    """How often learning did harm, and what it brought."""
    ratios = np.array([each.ratio for each in sessions])
    worse = int(np.count_nonzero(ratios > WORSE))
    return (
        f"{worse} of {len(sessions)} sessions above {WORSE} times the original ({worse / len(sessions):.1%}); "
        f"median {np.median(ratios):.3f}, mean {ratios.mean():.3f}, worst {ratios.max():.2f}"
    )


if __name__ == "__main__":
    main()
