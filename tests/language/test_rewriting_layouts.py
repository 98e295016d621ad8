"""Rules of any layout are rewritten to exactly the rules that are meant."""

import re

from hypothesis import given, reject, settings
from hypothesis import strategies as st

from grammarlab.errors import LanguageError
from grammarlab.language.checking.percentages import probabilities
from grammarlab.language.grammar import Grammar
from grammarlab.language.rewriting import Chances, RuleCopy, Same, Text, likely_last, rewrite
from grammarlab.language.syntax import printing
from grammarlab.language.syntax.syntax_tree import Case, Invoke, Rule, Stochastic, walk
from grammarlab.language.syntax.tokens import tokenize
from tests.language.trees import PHASES

# Comments are numbered, so that each can be found again; those inside heads begin with h.
SPACES = ["", "", "", " ", " ", "\n", "\n    ", "\r\n\t", "\n\n", " \n", "\x0b", "\u2028"]
COMMENTS = ["// 50% : {} else\n", "# {} /* \n", "/* {} */", "/* // {}\n # */", '//{} "\r\n  ', " /*{}*/\n"]
OPERATIONS = ["A", "B(1)", "[ A ]", "split(y){~1: A}", 'print("b // c # /*")', "t(0, 1, 0)", "X.", "B(1)A", ""]
WORD_END, WORD_START = re.compile(r"[\w.]$"), re.compile(r"[\w.(\[]")


@st.composite
def choices(draw, depth=2):
    """Words of a body."""
    kind = draw(st.sampled_from(["leaf", "chance", "chance", "chance", "case"])) if depth else "leaf"
    if kind == "leaf":
        return [draw(st.sampled_from(OPERATIONS))]
    heads = ["50", "20", "12.5", ".5", "p", "(p + 1)"] if kind == "chance" else ["scope.sx > 2", '"#" == "//"']
    words, chosen = [], draw(st.lists(st.sampled_from(heads), min_size=1, max_size=3))
    for head in chosen:
        words += [head, "%", ":"] if kind == "chance" else ["case", head, ":"]
        words += draw(choices(depth - 1))
    has_else = draw(st.integers(0, 3))
    return words + (["else", ":", *draw(choices(depth - 1))] if has_else else [])


@st.composite
def layouts(draw):
    """Rule files on one line or on several, with comments anywhere."""
    bodies = [draw(choices()), draw(choices()), draw(choices(1))]
    words = ["attr", "p", "=", "30"]
    for name, body in zip(("Lot", "House", "A"), bodies, strict=True):
        words += [*draw(st.sampled_from([[], [], ["@StartRule"]])), name, "-->", *body]
    words += ["f", "(", "n", ")", "=", "n", "B", "(", "n", ")", "-->", "X."]
    text, count = "", 0
    busy = draw(st.booleans())
    for word in filter(None, words):
        space = draw(st.sampled_from(SPACES))
        for comment in draw(st.lists(st.sampled_from(COMMENTS), max_size=2)) if busy and draw(st.booleans()) else []:
            count += 1
            space += comment.format(f"{'h' if word in ('%', ':') else 'c'}{count}c") + draw(st.sampled_from(SPACES))
        is_fused = WORD_END.search(text) and WORD_START.match(word)
        text += (space or (" " if is_fused else "")) + word
    return text + draw(st.sampled_from(["", "\n", " // end", "/* end */"]))


def grammar_of(text):
    """The grammar of a text, if it has the definitions that the layout was to have."""
    try:
        grammar = Grammar.parse(text)
    except LanguageError:
        reject()
    is_as_meant = set(grammar.rules) == {("Lot", 0), ("House", 0), ("A", 0), ("B", 1)}
    if not is_as_meant or len(grammar.tree.definitions) != 6:
        reject()
    return grammar


def leaf(text):
    """Printed operations, the empty ones in one way."""
    return "" if text == "[ ]" else text


def rules_of(choice):
    """What a body says, with percentages as probabilities, and without the end of those that sum to anything."""
    if not isinstance(choice, Case | Stochastic):
        return leaf(printing.sequence(choice))
    heads = choice.conditions if isinstance(choice, Case) else choice.percentages
    shares = probabilities(choice) if isinstance(choice, Stochastic) else None
    heads = shares or tuple(None if head is None else printing.expression(head) for head in heads)
    if heads == ("true", "true", None) and [rules_of(branch) for branch in choice.branches[1:]] == ["NIL", "NIL"]:
        return rules_of(choice.branches[0])
    return type(choice).__name__, tuple(heads), tuple(rules_of(branch) for branch in choice.branches)


@st.composite
def changes(draw, choice, path=(), keeps_all=False):
    """A new body, and what it says: with other percentages, without some branches, and renamed."""
    if not isinstance(choice, Case | Stochastic):
        is_renamed = not keeps_all and draw(st.booleans())
        names = {n.location: "Axe" for n in walk(choice) if isinstance(n, Invoke) and n.name == "A" and is_renamed}
        text = leaf(printing.sequence(choice))
        return Text(path, names), re.sub(r"\bA\b", "Axe", text) if is_renamed else text
    inner = [draw(changes(branch, (*path, i), keeps_all)) for i, branch in enumerate(choice.branches)]
    shares = probabilities(choice) if isinstance(choice, Stochastic) else None
    if shares is None:
        heads = choice.conditions if isinstance(choice, Case) else choice.percentages
        said = [None if head is None else printing.expression(head) for head in heads]
        closed = isinstance(choice, Case) and said[-1] is not None and bool(path)
        body = Same(path, tuple(body for body, _ in inner), closed)
        ends = ([None], ["NIL"]) if closed else ([], [])
        return body, (type(choice).__name__, (*said, *ends[0]), (*(text for _, text in inner), *ends[1]))
    kept = range(len(inner)) if keeps_all else draw(st.sets(st.sampled_from(range(len(inner))), min_size=1))
    weights = [(draw(st.sampled_from([1e-4, 1.0, 2.0, 5.0])), inner[i]) for i in sorted(kept)]
    flat = []
    for weight, (body, said) in weights:
        parts = body.branches if isinstance(body, Chances) else ((1.0, body),)
        texts = said[2] if isinstance(body, Chances) else (said,)
        flat += [(weight * share, (part, text)) for (share, part), text in zip(parts, texts, strict=True)]
    if len(flat) == 1:
        return flat[0][1]
    total = sum(weight for weight, _ in flat)
    branches = likely_last([(weight / total, pair) for weight, pair in flat])
    said = "Stochastic", tuple(share for share, _ in branches), tuple(text for _, (_, text) in branches)
    return Chances(tuple((share, body) for share, (body, _) in branches)), said


def are_equal(new, old):
    if isinstance(new, float) and isinstance(old, float):
        return abs(new - old) < 1e-9
    if isinstance(new, tuple) and isinstance(old, tuple):
        return len(new) == len(old) and all(are_equal(a, b) for a, b in zip(new, old, strict=True))
    return new == old


@given(layouts(), st.data())
@settings(max_examples=150, phases=PHASES)
def test_any_branches_of_any_layout_are_rewritten_to_the_rules_that_are_meant(text, data):
    grammar = grammar_of(text)
    copies, meant = {}, {key: rules_of(rule.body) for key, rule in grammar.rules.items()}
    for key in data.draw(st.sets(st.sampled_from(sorted(grammar.rules)), min_size=1)):
        removed = data.draw(st.integers(0, 3)) == 0
        split = [[key[0]], [f"{key[0]}_x"], [key[0], f"{key[0]}_x"]]
        names = [] if removed else data.draw(st.sampled_from(split))
        copies[key] = []
        del meant[key]
        for name in names:
            body, said = data.draw(changes(grammar.rules[key].body))
            copies[key].append(RuleCopy(name, body, data.draw(st.sampled_from(["", "why"]))))
            meant[name, key[1]] = said
    written = rewrite(grammar, copies)
    new = Grammar.parse(written)
    assert len([d for d in new.tree.definitions if isinstance(d, Rule)]) == len(meant) == len(new.rules)
    found = {key: rules_of(rule.body) for key, rule in new.rules.items()}
    assert (new.attributes, new.functions) == (grammar.attributes, grammar.functions)
    for key, said in meant.items():
        assert are_equal(found[key], said), key
    # A second time only branches without operations change.
    again = rewrite(new, {key: [RuleCopy(key[0], as_it_is(rule.body))] for key, rule in new.rules.items()})
    assert again.replace(" [ ]", "") == written.replace(" [ ]", "")


def as_it_is(choice, path=()):
    if not isinstance(choice, Case | Stochastic):
        return Text(path, {})
    bodies = [as_it_is(branch, (*path, i)) for i, branch in enumerate(choice.branches)]
    return Same(path, tuple(bodies))


@given(layouts(), st.data())
@settings(max_examples=100, phases=PHASES)
def test_no_comment_between_branches_is_lost_while_all_branches_stay(text, data):
    grammar = grammar_of(text)
    copies = {}
    for key, rule in grammar.rules.items():
        body, _ = data.draw(changes(rule.body, keeps_all=True))
        copies[key] = [RuleCopy(key[0], body)]
    written = rewrite(grammar, copies)
    # Those inside the heads go with the percentages.
    before, after = (
        {match for comment in tokenize(each).comments for match in re.findall(r"c\d+c", comment.text)}
        for each in (grammar.text, written)
    )
    assert before == after
