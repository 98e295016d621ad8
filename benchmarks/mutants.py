"""Mistakes put into the code on purpose, one at a time: how many of them do the tests notice?

Run with ``python -m benchmarks.mutants`` (``make mutants``), which takes about an hour; ``--check`` only looks for the
places, and numbers or parts of file names choose some: ``python -m benchmarks.mutants 3 clip``. Each mutant changes a
copy of the repository; this one stays as it is. The tests are run with all cases unless GRAMMARLAB_CASES says otherwise
(`tests/cases.py`), and in the order of their files until one fails.

A mutant is found by its text wherever its module is, and its tests by the name of one test in their file. Identifiers
that may be renamed are wildcards, so that one list is good for two versions: run both with ``--root`` and compare.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
LONGEST = 900.0
"""Seconds for the tests of a mutant; one that makes them endless is noticed."""
ANY = "§"
"""Stands for any identifier, with its attributes."""

COMPILE = ("test_every_tree_has_the_probability_that_brute_force_gives_it", "test_reading_less_changes_no_value")
"""Tests of exact densities of counts, named by one test in each file."""
CELLS = ("test_the_best_of_many_trees_is_the_best_of_all", "test_evidence_and_posterior_are_sums_over_all_values")
LIKELIHOOD = ("test_all_scores_of_a_scale_together_are_certain",)
SPLITTING = ("test_worked_examples", "test_the_parts_of_a_split_fill_the_whole")
SKELETON = (
    "test_every_edge_has_one_face_which_begins_with_it",
    "test_strips_and_remainder_are_the_whole",
    "test_exactly_two_faces_meet_at_every_edge_of_a_roof",
)
CLIP = ("test_slabs_of_a_solid_are_closed_and_fill_it",)
COUNTS = ("test_no_counts_in_a_box_cost_less_than_its_bound", "test_every_column_once_is_the_facade_itself")
STOPPING = ("test_nothing_is_left_to_gain_where_everything_is_known",)
POSTERIOR = ("test_prediction_equals_the_textbooks_dense_solve", "test_the_energy_is_that_of_a_dense_computation")
FEATURES = ("test_patterns_are_counted_as_their_definition_says",)


class Mutant(NamedTuple):
    """A change of one place in the code."""

    old: str
    """Text in exactly one module; `ANY` stands for an identifier."""
    new: str
    """What takes its place; ``{0}`` is the first identifier."""
    tests: tuple[str, ...]
    """Names of tests: the files that define them are run."""


MUTANTS = (
    # States that count patterns: the automaton of densities.
    Mutant("§ += len(§.run) - 1", "{0} += len({1}.run)", COMPILE),
    Mutant(
        "§[:, :, § - 1] * §[§]\n            §[:, :, §] = §[0]",
        "{0}[:, :, {1} - 1]\n            {4}[:, :, {5}] = {6}[0]",
        COMPILE,
    ),
    Mutant("§[0] = np.zeros_like(§[0])", "pass", COMPILE),
    Mutant("§[:, §] += § * §._matches(§, §)", "{0}[:, {1}] = {2} * {3}._matches({4}, {5})", COMPILE),
    Mutant("np.minimum(§ * np.minimum(§, §), §)", "np.minimum({0} + np.minimum({1}, {2}), {3})", COMPILE),
    Mutant("§.max(axis=0) + 1\n    if float(np.prod(", "{0}.max(axis=0)\n    if float(np.prod(", COMPILE),
    # Outside weights, and weights of variants.
    Mutant("§ = np.where(§ > 0.0, 0, -1)", "{0} = np.where({1} > 0.0, 0, 0)", COMPILE),
    Mutant("§ / §), § * §))", "{0}), {2} * {3}))", COMPILE),
    Mutant("int(§) for § in § if § >= 0}", "int({0}) for {1} in {2} if {3} > 0}}", COMPILE),
    Mutant("§ - § <= 1e-15 * §", "{0} - {1} <= 1e-3 * {2}", COMPILE),
    Mutant("§[§[§]] += §.weight * np.prod(", "{0}[{1}[{2}]] = {3}.weight * np.prod(", COMPILE),
    Mutant("float(§ > 0.0) for § in §.probabilities", "float({0} > 0.0) * 2.0 for {1} in {2}.probabilities", COMPILE),
    # A preference of cells: averages over its trees.
    Mutant("+ §**2)[§]\n", ")[{1}]\n", CELLS),
    Mutant("np.maximum(§ - §**2, 0.0) + §.noise**2", "np.maximum({0} - {1}**2, 0.0)", CELLS),
    Mutant("(100.0**2 / 12.0 + ", "(100.0 / 12.0 + ", CELLS),
    Mutant("§ / §.sum()))", "{0}))", CELLS),
    Mutant("@ §.cells.grid**2 - §**2", "@ {0}.cells.grid**2", CELLS),
    Mutant("[:, None] == §) * §[§]", "[:, None] != {0}) * {1}[{2}]", CELLS),
    # The likelihood of a score: the interval that it means.
    Mutant("(1.0 - §) * § + § * § / MAX_SCORE + §).astype", "(1.0 - {0}) * {1} + {4}).astype", LIKELIHOOD),
    Mutant("§ <= § / 2.0, § >= ", "{0} < 0.0, {2} >= ", LIKELIHOOD),
    Mutant("np.where(§ | §, §, 2.0 * §)", "np.where({0} | {1}, {2}, 1.0 * {3})", LIKELIHOOD),
    Mutant("/ §**2 / §\n", "/ {0} / {1}\n", LIKELIHOOD),
    Mutant("§ + §**2 * (§ - §**2)", "{0} + {1}**2 * ({2} + {3}**2)", LIKELIHOOD),
    Mutant("(§ - MAX_SCORE) * ndtr(-§)", "({0} - MAX_SCORE) * ndtr({1})", LIKELIHOOD),
    # Splits along an axis: repeats and floating sizes.
    Mutant("np.floor(§) - (len(§) - 1)", "np.floor({0}) - len({1}) + 2", SPLITTING),
    Mutant("np.abs(§ - 1.0), np.inf)", "{0} - 1.0, np.inf)", SPLITTING),
    Mutant("§ // § + (§ % § > §)", "{0} // {1} + ({2} % {3} >= {4})", SPLITTING),
    Mutant("np.ceil(§ - TOLERANCE)", "np.ceil({0} + TOLERANCE)", SPLITTING),
    Mutant("np.where(§ >= _reach(§), §, §)", "np.where({0} >= {1}, {2}, {3})", SPLITTING),
    Mutant("§ = 0 if any(isinstance(§, SplitSize)", "{0} = 1 if any(isinstance({1}, SplitSize)", SPLITTING),
    # The wavefront of a straight skeleton.
    Mutant("§ = § < § * § * (1.0 - §)\n", "{0} = {1} < {2} * {3}\n", SKELETON),
    Mutant("(§ and § < 0)):", "({0} and {1} > 0)):", SKELETON),
    Mutant("§.dx * §.dy - §.dy * §.dx > §:\n", "{0}.dx * {1}.dy - {2}.dy * {3}.dx < {4}:\n", SKELETON),
    Mutant("§ + max(§, 0.0) / §, next(", "{0} + {1} / {2}, next(", SKELETON),
    Mutant("§ = max(§.time, §.time)", "{0} = min({1}.time, {2}.time)", SKELETON),
    Mutant("0.5 * (§ + §), 0.5 * (§ + §)", "{0}, {2}", SKELETON),
    # Cutting meshes into slabs.
    Mutant("np.abs(§) <= §.slack[§].take(", "np.abs({0}) < 0.0 * {1}.slack[{2}].take(", CLIP),
    Mutant("(§ > §.take(§)) & (§ < §.take(§))", "({0} > {1}.take({2}))", CLIP),
    Mutant("[§[§], §] < 0.0\n", "[{0}[{1}], {2}] > 0.0\n", CLIP),
    Mutant("§.low[§] + §) | (", "{0}.low[{1}] - {2}) | (", CLIP),
    Mutant("§.low if § > 0.0 else §.high", "{0}.high if {1} > 0.0 else {2}.low", CLIP),
    Mutant("§.points[:, §] = §.level.take(§.mesh_of_point)", "pass", CLIP),
    # Numbers of repeated columns of a facade: bounds of springs.
    Mutant("2.0 * § * § - §**2 * §\n", "2.0 * {0} * {1} + {2}**2 * {3}\n", COUNTS),
    Mutant("§ - 0.5 * § / §)", "{0} + 0.5 * {1} / {2})", COUNTS),
    Mutant("(§**2 / §).sum()", "({0}**2 * {1}).sum()", COUNTS),
    Mutant("§[§], §[§] = §, § + 1", "{0}[{1}], {2}[{3}] = {4} - 1, {5} + 1", COUNTS),
    Mutant("§ >= § * (1.0 - §) - §", "{0} >= {1} * 0.5 * (1.0 - {2}) - {3}", COUNTS),
    Mutant(
        "if § < §:\n                §, §, § = §.least",
        "if {0} > {1}:\n                {2}, {3}, {4} = {5}.least",
        COUNTS,
    ),
    # What is left to learn, and the posterior of a Gaussian process.
    Mutant("None if § is None else § * § / (§ + §)", "None if {0} is None else {1} * {2} / {3}", STOPPING),
    Mutant(") * § / max(§ - §, 1)", ") / max({1} - {2}, 1)", STOPPING),
    Mutant("sum(§) / max(len(§) - 1, 1)", "sum({0}) / max(len({1}), 1)", STOPPING),
    Mutant("§, §) - 2.0 * § @ §.T", "{0}, {1}) - 1.0 * {2} @ {3}.T", POSTERIOR),
    Mutant('§ - np.einsum("nm,nm->m", §, §)', '{0} + np.einsum("nm,nm->m", {1}, {2})', POSTERIOR),
    Mutant("§.amplitude + §.noise\n", "{0}.amplitude\n", POSTERIOR),
    # Counts of features.
    Mutant("§.draws.value[§] < §\n", "{0}.draws.value[{1}] <= {2}\n", FEATURES),
    Mutant("§ / np.maximum(§, 1.0)\n            case Formula", "{0}\n            case Formula", FEATURES),
    Mutant("§[§] = §[§[§]] == §[§]", "pass", FEATURES),
    Mutant("np.minimum(§[§] * §[§[§]], ", "np.minimum({0}[{1}] + {2}[{3}[{4}]], ", FEATURES),
    Mutant("is None or §.branch[: len(§.branch)] == §.branch)", "is None or {0}.branch == {2}.branch)", FEATURES),
    Mutant("§ = §.child[§] == §\n", "{0} = {1}.child[{2}] >= {3}\n", FEATURES),
)


@cache
def sources(folder: Path, name: str) -> tuple[tuple[Path, str], ...]:
    """Files below a folder and their texts."""
    return tuple((path, path.read_text(encoding="utf-8")) for path in sorted(folder.rglob(name)))


def pattern_of(mutant: Mutant) -> re.Pattern[str]:
    """The text of a mutant, with any identifiers."""
    return re.compile(r"([A-Za-z_][\w.]*)".join(map(re.escape, mutant.old.split(ANY))))


def place_of(mutant: Mutant, root: Path) -> tuple[Path, re.Match[str]]:
    """The module and the only place of a mutant's text.

    Raises:
        LookupError: If it is nowhere, or in several places.
    """
    found = [
        (path, match)
        for path, text in sources(root / "grammarlab", "*.py")
        for match in pattern_of(mutant).finditer(text)
    ]
    if len(found) != 1:
        places = ", ".join(f"{path.relative_to(root)}: {match[0]!r}" for path, match in found)
        raise LookupError(f"expected one place of {mutant.old!r}, found {places or 'none'}")
    return found[0]


def tests_of(mutant: Mutant, root: Path) -> list[str]:
    """The files of a mutant's tests."""
    files = sources(root / "tests", "test_*.py")
    found: list[str] = []
    for name in mutant.tests:
        of_name = [path.relative_to(root).as_posix() for path, text in files if f"def {name}(" in text]
        if len(of_name) != 1:
            raise LookupError(f"expected one file with {name}, found {', '.join(of_name) or 'none'}")
        found += of_name
    return found


def changed(mutant: Mutant, root: Path) -> tuple[Path, str]:
    """The module of a mutant, and its text with the mistake."""
    path, match = place_of(mutant, root)
    text = match.string
    return path, text[: match.start()] + mutant.new.format(*match.groups()) + text[match.end() :]


def is_killed(mutant: Mutant, root: Path, copy: Path) -> bool:
    """Whether tests fail in a copy of the repository with the mistake; the copy is then as before."""
    path, text = changed(mutant, root)
    place = copy / path.relative_to(root)
    place.write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests_of(mutant, root)]
    environment = {"GRAMMARLAB_CASES": "all"} | os.environ | {"PYTHONPATH": str(copy)}
    try:
        done = subprocess.run(
            command, cwd=copy, env=environment, capture_output=True, text=True, check=False, timeout=LONGEST
        )
    except subprocess.TimeoutExpired:
        return True
    finally:
        shutil.copy2(path, place)
    if done.returncode not in (0, 1, 2):
        raise RuntimeError(done.stdout + done.stderr)
    return done.returncode != 0


def chosen(words: list[str], root: Path) -> Iterator[tuple[int, Mutant]]:
    """Mutants by number, by a part of the path of their module, or all."""
    for number, mutant in enumerate(MUTANTS, start=1):
        path = place_of(mutant, root)[0].relative_to(root).as_posix() if words else ""
        if not words or str(number) in words or any(not word.isdigit() and word in path for word in words):
            yield number, mutant


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("which", nargs="*", help="numbers of mutants, or parts of the paths of their modules")
    parser.add_argument("--root", type=Path, default=ROOT, help="the repository to change copies of")
    parser.add_argument("--check", action="store_true", help="only find all places and tests")
    options = parser.parse_args()
    root = options.root.resolve()
    wrong, survived, num = [], [], 0
    with TemporaryDirectory() as folder:
        copy = Path(folder) / "copy"
        if not options.check:
            left_out = shutil.ignore_patterns(".git", ".venv", "node_modules", "out", "__pycache__")
            shutil.copytree(root, copy, ignore=left_out)
        for number, mutant in chosen(options.which, root):
            num += 1
            try:
                path = changed(mutant, root)[0].relative_to(root).as_posix()
                tests_of(mutant, root)
            except LookupError as error:
                wrong.append(f"{number}: {error}")
                continue
            begun = time.monotonic()
            if options.check:
                print(f"{number:2} {path}: {mutant.old.strip()}  ->  {mutant.new.strip()}")
                continue
            killed = is_killed(mutant, root, copy)
            if not killed:
                survived.append(number)
            word = "killed" if killed else "survived"
            print(f"{number:2} {word:8} {time.monotonic() - begun:4.0f} s  {path}: {mutant.old.strip()}", flush=True)
    for text in wrong:
        print(text)
    if not options.check:
        print(f"{num - len(wrong) - len(survived)} of {num} killed; survived: {survived or 'none'}")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
