"""Versions in a manifest: of all that is installed, and nothing about what a machine does not have."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

import pytest

from grammarlab.runs.sample import manifest


def test_a_machine_without_embree_has_no_version_of_it(monkeypatch: pytest.MonkeyPatch):
    def without_embree(name: str) -> str:
        if name == "embreex":
            raise PackageNotFoundError(name)
        return version(name)

    manifest.current_versions.cache_clear()
    monkeypatch.setattr(manifest, "version", without_embree)
    try:
        versions = manifest.current_versions()
    finally:
        manifest.current_versions.cache_clear()
    assert "embreex" not in versions
    assert versions["numpy"] == version("numpy")
