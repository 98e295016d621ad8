"""Mutated example grammars: an error of ours or a forest, in bounded time; never anything else."""

from __future__ import annotations

from pathlib import Path

from hypothesis import HealthCheck, given
from hypothesis import strategies as st

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import Budget, derive
from grammarlab.errors import GrammarlabError
from grammarlab.language.grammar import Grammar
from tests.cases import bulk

GRAMMARS = Path(__file__).parents[3] / "grammars"
TEXTS = [(GRAMMARS / f"{name}.cga").read_text(encoding="utf-8") for name in ("toy", "furniture", "airplane")]
ASSETS = AssetFolder(GRAMMARS / "assets")
TOKENS = [
    *("0", "1e9", "-3", "~", "'", "'0.5", "%", "50%", "else", "case", ":", "|", "{", "}", "}*", "[", "]", "(", ")"),
    *(
        "-->",
        "rand(1, 2)",
        "p(2)",
        "0 / 0",
        '"x"',
        "scope.sx",
        "split(x)",
        "comp(f)",
        "extrude",
        "NIL",
        "Lot",
        "T.",
        "==",
    ),
    *("extrude(-2)", "taper(-1)", "comp(fe)", "comp(e, noAlign)", "top || front", "geometry.area() > 3", "=:"),
    *("listRandom", 'replace("a", 1, 2)', 'getRange("a", 3)', "colorRGBToHex(0 / 0, 1, 2)", 'sel("x")', "find"),
    *("roofHip(30)", "offset(-1)", "setback(1)", "alignScopeToAxes(y)", "mirror(true, false, false)", "taper(1)"),
]


@st.composite
def mutated(draw: st.DrawFn) -> str:
    """An example with a few words replaced, removed, doubled or swapped."""
    words = draw(st.sampled_from(TEXTS)).split(" ")
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.integers(0, len(words) - 2))
        kind = draw(st.integers(0, 3))
        if kind == 0:
            words[place] = draw(st.sampled_from(TOKENS))
        elif kind == 1:
            del words[place]
        elif kind == 2:
            words.insert(place, words[place])
        else:
            words[place], words[place + 1] = words[place + 1], words[place]
    return " ".join(words)


@given(mutated())
@bulk(150, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
def test_a_mutated_grammar_derives_or_says_why_not(text):
    try:
        forest = derive(Grammar.parse(text), 2, 1, assets=ASSETS, budget=Budget(shapes=5_000, depth=50))
    except GrammarlabError as error:
        outcome = str(error)
    else:
        outcome = f"{forest.num_models} models"
    assert outcome
