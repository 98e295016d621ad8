"""The shipped rule files that import no others, for tests that read a text alone."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).parents[1] / "grammars"
WHOLE = [path for path in sorted(FOLDER.glob("*.cga")) if "\nimport " not in path.read_text(encoding="utf-8")]
