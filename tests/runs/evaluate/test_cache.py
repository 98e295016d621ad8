import numpy as np
import pytest

from grammarlab.runs.evaluate.cache import keep_in

ARRAYS = {"rows": np.arange(6.0).reshape(2, 3), "names": np.array(["a", "längst"])}


def same(one, other):
    return set(one) == set(other) and all(np.array_equal(one[name], other[name]) for name in one)


def test_arrays_are_made_once_and_read_back_unchanged(tmp_path):
    keep = keep_in(tmp_path / "cache")
    assert same(keep("key", lambda: ARRAYS), ARRAYS)
    assert same(keep("key", dict), ARRAYS)
    assert not same(keep("other", dict), ARRAYS)


@pytest.mark.parametrize("length", [0, 1, 50, -1])
def test_a_broken_file_is_made_again(tmp_path, length):
    keep = keep_in(tmp_path)
    keep("key", lambda: ARRAYS)
    (file,) = tmp_path.iterdir()
    file.write_bytes(file.read_bytes()[:length])
    assert same(keep("key", lambda: ARRAYS), ARRAYS)
    assert same(keep("key", dict), ARRAYS)


def test_a_file_that_would_run_code_is_not_loaded(tmp_path):
    np.savez(tmp_path / "key.npz", rows=np.array([print], dtype=object))
    assert same(keep_in(tmp_path)("key", lambda: ARRAYS), ARRAYS)
