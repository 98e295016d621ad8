"""A score that is saved against a bare SQLite commit, an open session against the JSON in its file, and an update with
200 labels as a person sees it: until the new models are drawn, and the longest time that the page does not react."""

from __future__ import annotations

import json
import os
import sqlite3
from contextlib import closing
from itertools import count
from pathlib import Path

import pytest
from playwright.sync_api import expect, sync_playwright

from grammarlab.pages.record.store import About, Store
from grammarlab.pages.scoring.knowledge import ModelPool
from grammarlab.pages.scoring.session import Session
from tests.browser.chromium import ARGUMENTS, CHROMIUM, needs_chromium
from tests.browser.driver import ScoringPage, Server
from tests.browser.scoring.test_simulated_person import Person
from tests.runs.processes import descendants

ABOUT = About("toy", "Lot --> extrude(3)", 5, 100)
NUM_EVENTS = 2_000


@pytest.fixture
def file(tmp_path):
    with closing(Store.open(tmp_path / "s.db", ABOUT)) as store:
        store._connection.execute("PRAGMA synchronous = OFF")
        for number in range(NUM_EVENTS):
            store.append("score", {"factor": "overall", "models": [f"g5-{number}"], "score": 50})
    return tmp_path / "s.db"


@pytest.mark.benchmark(group="save a score")
def test_bare_commit(benchmark, tmp_path):
    with closing(sqlite3.connect(tmp_path / "s.db", isolation_level=None)) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("CREATE TABLE events (number INTEGER PRIMARY KEY, body TEXT)")
        numbers = count(1)
        benchmark(lambda: connection.execute("INSERT INTO events VALUES (?, ?)", (next(numbers), "x" * 80)))


@pytest.mark.benchmark(group="save a score")
def test_event(benchmark, file):
    with closing(Store.open(file)) as store:
        body = {"factor": "overall", "models": ["g5-1"], "score": 50}
        benchmark(lambda: store.append("score", body))


@pytest.mark.benchmark(group="save a score")
def test_session(benchmark, tmp_path):
    with closing(Session("toy", tmp_path / "s.db", jobs=0)) as session:
        models = list(session.call("state")[0]["models"])
        benchmark(lambda: session.call("score", models=models[:1], score=50))


@pytest.mark.benchmark(group="100 models in another order")
@pytest.mark.parametrize("by", ["score", "random", "shown"])
def test_sort(benchmark, tmp_path, by):
    with closing(Session("toy", tmp_path / "s.db", jobs=0)) as session:
        session.call("layout", grids=1, rows=10, columns=10)
        benchmark(lambda: session.call("sort", by=by))


@pytest.mark.benchmark(group=f"read {NUM_EVENTS} events")
def test_json(benchmark, file):
    def read():
        with closing(sqlite3.connect(file)) as connection:
            return [json.loads(body) for (body,) in connection.execute("SELECT body FROM events")]

    assert len(benchmark(read)) == NUM_EVENTS


@pytest.mark.benchmark(group=f"read {NUM_EVENTS} events")
def test_open(benchmark, file):
    def read():
        with closing(Store.open(file)) as store:
            return store.record.revision

    assert benchmark(read) == NUM_EVENTS


NUM_LABELS = 200
OBSERVE = """
() => {
  const [begin, before] = [performance.now(), models()];
  const seen = { tasks: [], frame: 0, drawn: 0 };
  const observer = new PerformanceObserver((list) => {
    seen.tasks.push(...list.getEntries().map((task) => task.duration));
  });
  observer.observe({ type: 'longtask' });
  function models() {
    return [...document.querySelectorAll('.gl-cell')].map((cell) => cell.dataset.model).join();
  }
  window.measured = new Promise((done) => {
    let last = begin;
    requestAnimationFrame(function look() {
      const now = performance.now();
      seen.frame = Math.max(seen.frame, now - last);
      last = now;
      if (models() === before || document.querySelector('.gl-empty')) return requestAnimationFrame(look);
      seen.drawn = now - begin;
      // The good pictures that follow the quick ones count for the frames, too.
      setTimeout(() => {
        observer.disconnect();
        done({ drawn: seen.drawn / 1000, frame: seen.frame, tasks: seen.tasks });
      }, 2000);
    });
  });
  document.body.dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter', ctrlKey: true, bubbles: true }));
}
"""
"""Asks to learn from all scores; tells s until the new models are drawn, ms of the longest gap between frames and of
long tasks."""


@pytest.fixture
def labelled(tmp_path):
    """A session about buildings with labels of a simulated person."""
    person, path = Person("B1"), tmp_path / "s.db"
    with closing(Session("building", path, jobs=0)) as session:
        pool = ModelPool(0, 5_000)
        for score, models in person.judgement(list(pool.names[:NUM_LABELS])).items():
            session.call("score", models=models, score=score)
    return path


@needs_chromium
@pytest.mark.benchmark(group=f"an update with {NUM_LABELS} labels")
def test_update(benchmark, labelled):
    server = Server("building", labelled).start()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        page = ScoringPage(browser.new_page(viewport={"width": 1280, "height": 800}))
        page.page.set_default_timeout(120_000)
        page.page.goto(server.address)
        expect(page.page.get_by_text("the predictions know them all")).to_be_visible(timeout=120_000)
        page.expect_pictures()
        assert server.process is not None
        found, used, tasks, processes = [], [], [], [server.process.pid, *descendants(server.process.pid)]

        def update():
            before = [seconds_of(pid) for pid in processes]
            browser.start_tracing(page=page.page, categories=["toplevel", "disabled-by-default-devtools.timeline"])
            page.page.evaluate(OBSERVE)
            found.append(page.page.evaluate("window.measured"))
            tasks.append(milliseconds_of_tasks(browser.stop_tracing())[:3])
            used.append(sorted(seconds_of(pid) - start for pid, start in zip(processes, before, strict=True)))

        benchmark.pedantic(update, rounds=3, warmup_rounds=1)
        browser.close()
    server.kill()
    benchmark.extra_info["s until drawn"] = sorted(each["drawn"] for each in found[1:])
    benchmark.extra_info["ms of the longest frame"] = sorted(each["frame"] for each in found[1:])
    benchmark.extra_info["ms of long tasks"] = [each["tasks"] for each in found[1:]]
    benchmark.extra_info["ms of processor time of the page's longest tasks"] = tasks[1:]
    benchmark.extra_info["s of each process"] = used[1:]
    benchmark.extra_info["load"] = os.getloadavg()[0]
    print(benchmark.extra_info)


def milliseconds_of_tasks(trace):
    """Processor time of each thing that the page did without a pause, the longest first."""
    events = json.loads(trace)["traceEvents"]
    threads = {(e["pid"], e["tid"]) for e in events if e.get("args", {}).get("name") == "CrRendererMain"}
    tasks = [e for e in events if e["name"].endswith("RunTask") and (e["pid"], e["tid"]) in threads]
    return sorted((e.get("tdur", 0) / 1000 for e in tasks), reverse=True)


def seconds_of(process):
    """Processor time that a process has had."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
