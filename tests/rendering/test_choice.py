"""Which renderer draws: never a crash or a hang where OpenGL is missing or broken."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from grammarlab.errors import UsageError
from grammarlab.rendering import choice as choice_module
from grammarlab.rendering.choice import RendererChoice, choose
from grammarlab.rendering.rasterize import OpenGLRenderer
from grammarlab.rendering.raycast import RaycastRenderer
from tests.cases import takes_turns
from tests.waiting import PATIENCE


def trial_that(code, monkeypatch):
    """Let a line of Python stand for the program that tries OpenGL out."""
    real = subprocess.run

    def run(command, **options):
        return real([sys.executable, "-c", code, command[-1]], **options)

    monkeypatch.setattr(subprocess, "run", run)


def test_rays_are_chosen_without_starting_anything(monkeypatch):
    monkeypatch.setattr(subprocess, "run", None)
    assert choose("cast") == RendererChoice("cast")
    assert isinstance(RendererChoice("cast").make(), RaycastRenderer)


@pytest.mark.parametrize(
    ("code", "reason"),
    [
        ("raise ImportError('no pyrender')", "no pyrender"),
        ("import os; os.abort()", "ended with code"),
        ("import os, sys; os.write(1, b'driver'); os._exit(3)", "ended with code 3"),
        ("pass", "ended with code 0"),
    ],
)
def test_where_opengl_fails_auto_means_rays_and_gl_is_refused_with_the_reason(code, reason, monkeypatch):
    trial_that(code, monkeypatch)
    assert choose("auto", PATIENCE) == RendererChoice("cast")
    with pytest.raises(UsageError, match=r"OpenGL does not work here.*grammarlab\[gl\].*'cast'") as caught:
        choose("gl", PATIENCE)
    assert reason in str(caught.value)


def test_a_driver_that_hangs_is_given_up_in_time(monkeypatch):
    trial_that("import time; time.sleep(6000)", monkeypatch)
    with pytest.raises(UsageError, match=r"egl: no answer within .*osmesa: no time left"):
        choose("gl", timeout=0.2)
    assert choose("auto", timeout=0.2) == RendererChoice("cast")


def test_a_missing_interpreter_is_no_crash(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/nonexistent/python")
    assert choose("auto") == RendererChoice("cast")


def test_the_first_platform_that_works_is_chosen(monkeypatch):
    trial_that("import sys; sys.argv[1] == 'osmesa' or sys.exit(1); print('noise'); print('driver 1')", monkeypatch)
    found = choose("auto", PATIENCE)
    assert found == choose("gl", PATIENCE) == RendererChoice("gl", "osmesa", "driver 1")
    assert found.make() == OpenGLRenderer("osmesa")


@takes_turns
def test_trying_leaves_the_environment_alone(monkeypatch):
    monkeypatch.delenv("PYOPENGL_PLATFORM", raising=False)
    before = dict(os.environ)
    choose("auto")
    assert dict(os.environ) == before


def test_a_platform_that_does_not_exist_is_refused_by_the_real_trial(monkeypatch):
    monkeypatch.setattr(choice_module, "PLATFORMS", ("nonsense",))
    with pytest.raises(UsageError, match="nonsense: "):
        choose("gl", PATIENCE)
