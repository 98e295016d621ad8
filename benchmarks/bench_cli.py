"""How long the command line takes to answer, from a warm disk: the start of Python included."""

from __future__ import annotations

import subprocess
import sys

import pytest

COMMAND = (sys.executable, "-c", "from grammarlab.cli import main; main()")


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["list"]], ids=" ".join)
def test_answer(benchmark, arguments):
    benchmark.pedantic(lambda: subprocess.run([*COMMAND, *arguments], check=True, capture_output=True), rounds=5)


def test_sample_one_toy_without_a_picture(benchmark, tmp_path):
    arguments = ["sample", "toy", "-n", "1", "--no-image", "-o", str(tmp_path)]
    benchmark.pedantic(lambda: subprocess.run([*COMMAND, *arguments], check=True, capture_output=True), rounds=5)


def test_write_64_buildings(benchmark, tmp_path):
    from grammarlab.runs.sample.request import SampleRequest
    from grammarlab.runs.sample.run import sample_run

    request = SampleRequest.of("building", num_models=64, seed=1, image=False)
    benchmark.pedantic(sample_run, (request, tmp_path), rounds=2, warmup_rounds=1)
