"""The models of runs as one page that needs nothing else: to look at, and to send."""

from __future__ import annotations

import base64
import gzip
import html
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from shlex import quote
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from grammarlab.derivation.expressions import number_grammar
from grammarlab.errors import AssetError, UsageError
from grammarlab.export import SaveOptions, save
from grammarlab.pages import STATIC
from grammarlab.pages.listed_trees import listed_tree
from grammarlab.runs.sample.derivations import load_forest
from grammarlab.runs.sample.grammar_models import GrammarModels
from grammarlab.runs.sample.manifest import read_manifest
from grammarlab.runs.sample.models import Batch, cut_batches, models_of
from grammarlab.runs.sample.records import DERIVATIONS, ModelRecord, compiled, read_record
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.trace import forms_of, trace_of, tree_rows
from grammarlab.scene import Scene, realize
from grammarlab.scene.instances import scene_of_model
from grammarlab.scene.scene_pictures import with_pictures
from grammarlab.scene.used_tables import with_used_tables

MAX_BYTES = 32 << 20
"""Largest size of the models of a page in bytes: most mail programs send less, and every browser opens it at once."""
MOST_RUNS = 2
_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline'; style-src \
'unsafe-inline'; img-src blob: data:; connect-src blob: data:; base-uri 'none'; form-action 'none'">
<title>{title}</title>
<link rel="icon" href="data:,">
<style>{style}</style>
</head>
<body class="gl-alone">
<main id="grammarlab"></main>
<noscript>This page shows its models with JavaScript, which is part of it.</noscript>
<script type="application/json" id="runs">{data}</script>
<script type="module">{script}</script>
</body>
</html>
"""


@dataclass(frozen=True, slots=True)
class RunPage:
    """One page."""

    content: str
    """HTML with all that it needs."""
    left_out: tuple[int, ...]
    """Number of models of each run that are not in it, since it would be too large."""


def run_page(folders: Sequence[Path], max_bytes: int = MAX_BYTES, *, sent: bool = False) -> RunPage:
    """A page with the models of one run, or of two side by side, from what their folders hold.

    Args:
        folders: folders of runs, as `grammarlab.runs.sample.run.sample_run` writes them.
        max_bytes: largest size of all models; later models are left out.
        sent: whether the page may be opened elsewhere: it names folders without paths, which are private and lead
            nowhere there. Otherwise the options that it offers have the folders as they are given.

    Raises:
        UsageError: If there is not one run or two.
        AssetError: If a folder has no run, no finished model, or is damaged.
    """
    if not 1 <= len(folders) <= MOST_RUNS:
        raise UsageError(f"expected one run, or two side by side, found {len(folders)}")
    runs, left_out = [], []
    for folder in folders:
        request = read_manifest(folder).request
        models = _within(_models(folder, request), max_bytes // len(folders))
        if not models:
            raise AssetError(f"{folder}: no finished model that can be shown; continue it with sample --resume.")
        missing = request.total_models - len(models)
        left_out.append(missing)
        name = f"{request.name}, seed {request.seed}"
        runs.append({"name": name, **_examples(folder, sent), "models": models, "leftOut": missing})
    if len({run["name"] for run in runs}) < len(runs):
        names = _different_names(folders, sent)
        runs = [{**run, "name": f"{run['name']}, in {folder}"} for run, folder in zip(runs, names, strict=True)]
    text = json.dumps(runs, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    built = STATIC / "view"
    content = _PAGE.format(
        title=html.escape(" and ".join(run["name"] for run in runs) + " – grammarlab"),
        style=(built / "page.css").read_text(encoding="utf-8").replace("</", "<\\/"),
        script=(built / "page.js").read_text(encoding="utf-8").replace("</script", "<\\/script"),
        data=text,
    )
    return RunPage(content, tuple(left_out))


def _examples(folder: Path, sent: bool) -> dict[str, str]:
    """The folder as an argument of ``learn --examples`` in a shell, and from where it leads to the run."""
    start = f"where the folder {_name(folder)} is" if sent else "where grammarlab view was started"
    return {"folder": quote(_name(folder) if sent else folder.as_posix()), "start": start}


def _name(folder: Path) -> str:
    return folder.resolve().name


def _different_names(folders: Sequence[Path], sent: bool) -> list[str]:
    """Names of folders with as much of their paths as tells them apart, or a number where paths do not or may not."""
    parts = [folder.resolve().parts for folder in folders]
    for length in range(1, 2 if sent else max(map(len, parts)) + 1):
        names = ["/".join(part[-length:]) for part in parts]
        if len(set(names)) == len(names):
            return names
    return [f"{_name(folder)} ({number})" for number, folder in enumerate(folders, 1)]


def _within(models: Iterator[dict[str, Any]], max_bytes: int) -> list[dict[str, Any]]:
    """The first models whose texts have at most so many bytes in all."""
    selected: list[dict[str, Any]] = []
    total = 0
    for model in models:
        total += len(json.dumps(model))
        if total > max_bytes:
            break
        selected.append(model)
    return selected


def _models(folder: Path, request: SampleRequest) -> Iterator[dict[str, Any]]:
    """The finished models of a run, one after the other."""
    for batch in cut_batches(request):
        record = read_record(folder, request, batch)
        if record is None:
            continue
        count = 0
        for scene, trees in _scenes(folder, request, batch):
            pictured = with_pictures(scene, request.assets)
            for index in range(scene.num_models):
                yield _entry(record.models[count], scene_of_model(pictured, index), next(trees, []))
                count += 1


def _scenes(folder: Path, request: SampleRequest, batch: Batch) -> Iterator[tuple[Scene, Iterator[list[list[Any]]]]]:
    """Scenes of a batch, each with the rows of the trees of its models; those of a species have none."""
    models, stored = models_of(request), folder / DERIVATIONS / f"{batch.index:05d}"
    if not isinstance(models, GrammarModels):
        for scene in models.stored(request, batch, stored):
            yield scene, iter(())
        return
    forest = load_forest(stored)
    rules, _ = compiled(request.text, request.name)
    trace = trace_of(forest, number_grammar(rules), request.name, 0)
    forms = forms_of(trace)
    roots = np.flatnonzero(forest.nodes.parent < 0).tolist()
    yield realize(forest), (listed_tree(tree_rows(trace, root=root, forms=forms)) for root in roots)


def _entry(record: ModelRecord, scene: Scene, tree: list[list[Any]]) -> dict[str, Any]:
    reports = {key: report["sum"] for key, report in record.reports.items() if report.get("sum") is not None}
    glb = base64.b64encode(gzip.compress(_glb(scene), mtime=0)).decode()
    return {
        "index": record.index,
        "seed": str(record.seed),
        "shapes": record.shapes,
        "triangles": record.triangles,
        "reports": reports,
        "tree": tree,
        "glb": glb,
    }


def _glb(scene: Scene) -> bytes:
    """A small file of a model near its own origin, since graphics cards compute with 32 bits."""
    near = replace(with_used_tables(scene), origins=np.zeros((1, 3)))
    with TemporaryDirectory() as folder:
        return save(near, Path(folder, "model.glb"), options=SaveOptions(reuse="instancing")).read_bytes()
