"""The shipped grammars at scale: warnings are errors in tests, so none of these makes one."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import compile_grammar, derive_chunks
from grammarlab.language.importing import load
from tests.cases import some
from tests.whole_grammars import WHOLE

GRAMMARS = WHOLE
ASSETS = AssetFolder(GRAMMARS[0].parent / "assets")
NUM_MODELS = 10_000


@pytest.mark.parametrize("path", some(GRAMMARS), ids=lambda path: path.stem)
def test_ten_thousand_models_of_a_shipped_grammar_are_sound(path):
    done = 0
    for forest in derive_chunks(compile_grammar(load(path)), NUM_MODELS, 23, assets=ASSETS):
        done += forest.num_models
        leaves = forest.leaves
        owners = np.bincount(forest.nodes.model[leaves.node], minlength=forest.num_models)
        assert (owners > 0).all()
        assert np.isfinite(leaves.position).all()
        assert (leaves.size >= 0.0).all()
        assert np.isfinite(leaves.size).all()
        assert np.isfinite(forest.log_probability()).all()
    assert done == NUM_MODELS
