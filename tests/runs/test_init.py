"""What `grammarlab.runs` offers."""

import subprocess
import sys

import pytest

from grammarlab import runs


def test_every_public_name_can_be_had():
    for name in runs.__all__:
        assert getattr(runs, name).__name__ == name
        assert name in dir(runs)


@pytest.mark.parametrize("name", ["nonsense", "numpy"])
def test_other_names_are_refused(name):
    with pytest.raises(AttributeError, match=f"no attribute '{name}'"):
        getattr(runs, name)


def test_listing_grammars_does_not_load_the_engine():
    code = "import sys; from grammarlab.runs.requests.examples import shipped_examples; print('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"
