import pytest


@pytest.fixture(autouse=True)
def small_cards(monkeypatch: pytest.MonkeyPatch) -> None:
    """Trees far away are pictures of few pixels: making large ones takes longer than all else of a small city."""
    monkeypatch.setattr("grammarlab.trees.cards.PIXELS", 32)
