"""Random syntax trees, and random texts that look like rule files."""

from hypothesis import Phase
from hypothesis import strategies as st

from grammarlab.language.syntax.syntax_tree import (
    Annotation,
    Array,
    Attribute,
    Binary,
    Block,
    Boolean,
    Call,
    Case,
    Components,
    Floating,
    Function,
    Group,
    Import,
    Index,
    Inline,
    Invoke,
    Name,
    Number,
    Part,
    Relative,
    Rule,
    RuleFile,
    Scatter,
    Scoped,
    Sequence,
    Span,
    Stochastic,
    String,
    Style,
    Unary,
    Variable,
)

PHASES = (Phase.explicit, Phase.reuse, Phase.generate, Phase.shrink)
"""Without the explaining phase, which takes minutes to print a tree."""

_OPERATORS = ["+", "-", "*", "/", "%", "==", "!=", "<", "<=", ">", ">=", "&&", "||"]
_ELEMENT_WISE = [f".{operator}" for operator in _OPERATORS]

names = st.sampled_from(["a", "b", "height", "Wall", "scope.sx", "lib.colour", "x1", "start", "with", "inlined", "f"])
plain_names = st.sampled_from(["a", "b", "height", "Wall", "x1", "f", "start", "extension", "with", "öl"])
symbols = st.one_of(names, st.sampled_from(["Roof.", "NIL", "extrude", "center"]))
numbers = st.builds(Number, st.floats(0, allow_infinity=False, allow_nan=False).map(abs))
strings = st.builds(String, st.text(st.sampled_from('abc \\"\n\t#/*ü€|{}'), max_size=8))


def _tuples(elements, least=0, most=3):
    return st.lists(elements, min_size=least, max_size=most).map(tuple)


def _expressions(inner):
    # A choice is a choice of expressions inside an expression; the parser makes no others.
    return st.one_of(
        st.builds(Call, names, _tuples(inner)),
        st.builds(Unary, st.sampled_from(["-", "+", "!", ".-", ".!"]), inner),
        st.builds(Binary, st.sampled_from(_OPERATORS + _ELEMENT_WISE), inner, inner),
        st.builds(Relative, inner),
        st.builds(Index, names.map(Name), _tuples(inner, 1, 2)),
        st.builds(Array, _tuples(_tuples(st.one_of(inner, st.builds(Span, inner, inner)), 1, 2), 0, 2)),
        st.builds(Array, st.builds(Span, inner, inner, inner).map(lambda span: ((span,),))),
        st.builds(Components, _tuples(inner, 1, 1), _tuples(st.builds(Part, inner, inner), 1, 2)),
        _choices(inner, inner),
    )


def _choices(conditions, leaves):
    """Choices that end in else, so that any nesting of them can be written."""

    def close(kind, heads, branches):
        return kind((*heads, None), tuple(branches[: len(heads) + 1]))

    return st.builds(
        close,
        st.sampled_from([Case, Stochastic]),
        _tuples(conditions, 1, 2),
        st.lists(leaves, min_size=3, max_size=3),
    )


expressions = st.recursive(
    st.one_of(numbers, strings, st.booleans().map(Boolean), names.map(Name)), _expressions, max_leaves=8
)
sizes = st.one_of(expressions, st.builds(Floating, expressions), st.builds(Floating, st.builds(Relative, expressions)))


def _invocations(arguments):
    return st.builds(lambda name, given: Invoke(name, given, bool(given)), symbols, arguments)


def _operations(inner):
    """Items with bodies, from bodies."""
    parts = st.builds(Part, sizes, inner, st.booleans())
    members = st.one_of(parts, st.builds(Group, _tuples(parts, 1, 2), st.booleans()))
    groups = st.builds(Group, _tuples(members, 1, 3), st.booleans())
    arguments = _tuples(expressions, 0, 2)
    single = st.builds(lambda item: Sequence((item,)), _invocations(arguments))
    items = st.one_of(
        _invocations(arguments),
        st.builds(Block, symbols.filter(lambda name: name != "scatter"), arguments, groups),
        st.builds(Scoped, inner),
        st.builds(Scatter, _tuples(expressions, 1, 2), inner),
        st.builds(Inline, st.just("inline"), st.sampled_from(["", "append"]), single),
        st.builds(Inline, st.sampled_from(["union", "subtract", "intersect"]), st.sampled_from(["", "swap"]), single),
        st.builds(Inline, st.sampled_from(["union", "subtract", "intersect"]), st.just(""), single, single),
    )
    sequences = st.builds(Sequence, _tuples(items, 1, 3))
    return st.one_of(sequences, _choices(expressions, sequences))


bodies = st.recursive(
    st.builds(Sequence, _tuples(_invocations(_tuples(expressions, 0, 2)), 0, 3)), _operations, max_leaves=6
)
annotations = _tuples(
    st.builds(
        Annotation,
        st.sampled_from(["Range", "Hidden", "Group"]),
        _tuples(st.tuples(st.sampled_from(["", "min"]), numbers)),
    ),
    0,
    2,
)
_variables = _tuples(st.builds(Variable, plain_names, expressions), 0, 1)
_parameters = _tuples(plain_names, 0, 2)
definitions = st.one_of(
    st.builds(Attribute, plain_names, expressions, st.booleans(), annotations, _variables),
    st.builds(Function, plain_names, _parameters, expressions, st.booleans(), annotations, _variables),
    st.builds(
        Rule, plain_names, _parameters, bodies, annotations, _variables, st.sampled_from(["", "start", "extension"])
    ),
    st.builds(
        Import, plain_names, st.just("lib/file.cga"), _tuples(st.tuples(plain_names, expressions), 0, 2), annotations
    ),
    st.builds(Style, plain_names, st.sampled_from(["", "Base"]), annotations),
)
rule_files = st.builds(RuleFile, st.sampled_from(["", "2023.0"]), _tuples(definitions, 0, 4))

_WORDS = [
    *["-->", "{", "}", "(", ")", "[", "]", "|", ":", "=", "==", "%", "*", "~", "'", ",", ";", "@", "^", ".", "-", "+"],
    *["case", "else", "attr", "const", "import", "style", "extends", "version", "inline", "union", "with", "start"],
    *[
        "Lot",
        "A",
        "b",
        "x",
        "scatter",
        "split",
        "comp",
        "extrude",
        "NIL",
        "Roof.",
        "a.b",
        "1",
        ".5",
        "1e3",
        "30%",
        '"s"',
    ],
    *[
        "\n",
        "\r\n",
        "// c\n",
        "# c\n",
        "/* c */",
        "/*",
        '"',
        "->",
        ":=",
        "=:",
        "&",
        "?",
        "\x00",
        "é",
        "\u2028",
        "\ufeff",
    ],
]
token_soup = st.lists(st.sampled_from(_WORDS), max_size=60).map(" ".join)
