"""Curves of a small world, made by functions that other processes can import."""

from itertools import count
from pathlib import Path
from threading import Event

from grammarlab.evaluation import protocol
from grammarlab.evaluation.methods import Method
from grammarlab.runs.evaluate.curve_store import CurveRecord
from grammarlab.runs.evaluate.curve_tasks import CurveTask, run_tasks
from tests.evaluation.doubles import world

METHODS = (Method("default"), Method("paper", fit="paper", batch=32))


def tasks(seeds=3, max_labels=32):
    return [
        CurveTask(Path("F1.toml"), "source", method, seed, max_labels, Path("cache"))
        for method in METHODS
        for seed in range(seeds)
    ]


def make(task):
    """The curve of a task; a quick learner makes it, since what is tested is which curves are made."""
    material = world(fit="kde", query="density", warm=True)
    _, curve = protocol.run(material, task.method.batch, task.seed, task.max_labels)
    return CurveRecord(task.key, "F1", task.method.name, task.seed, task.max_labels, material.js_original, curve)


def refuse(task):
    raise AssertionError(f"{task} is there already")


def run_two(folder):
    """Makes two curves, and then waits to be killed."""
    left = count(2, -1)

    def make_or_wait(task):
        if not next(left):
            Event().wait()
        return make(task)

    run_tasks(make_or_wait, tasks(2), Path(folder))
