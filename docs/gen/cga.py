"""The words of CGA as tables: every operation, function and shape attribute, and whether derivations support it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from grammarlab.derivation.operations import LEFT_OUT
from grammarlab.language.syntax.builtins import Signature, Signatures
from grammarlab.language.syntax.builtins import attributes as known_attributes
from grammarlab.language.syntax.builtins import blocks as known_blocks
from grammarlab.language.syntax.builtins import functions as known_functions
from grammarlab.language.syntax.builtins import operations as known_operations
from grammarlab.language.syntax.keywords import KEYWORDS
from grammarlab.runs.sample.checks import SUPPORTED

_OPERATIONS, _FUNCTIONS, _ATTRIBUTES, _WORDS = (
    words or frozenset()
    for words in (SUPPORTED.operations, SUPPORTED.functions, SUPPORTED.attributes, SUPPORTED.keywords)
)
YES, IGNORED, NO = "yes", "ignored, with a warning", "no"


def operations() -> Mapping[str, str]:
    """Whether each operation is supported, by name."""
    supported = {name: YES if name in _OPERATIONS else NO for name in _operations()}
    return supported | dict.fromkeys(LEFT_OUT, IGNORED)


def functions() -> Mapping[str, str]:
    """Whether each function is supported, by name."""
    return {name: YES if name in _FUNCTIONS else NO for name in known_functions()}


def attributes() -> Mapping[str, str]:
    """Whether each shape attribute is supported, by name."""

    def support(name: str) -> str:
        return YES if name in _ATTRIBUTES else IGNORED if name in SUPPORTED.harmless else NO

    return {name: support(name) for name in known_attributes()}


def tables() -> str:
    """Tables in Markdown: operations, functions and attributes, each with the number of supported ones, and words."""
    return "\n\n".join(
        (
            _section("Operations", operations(), _forms(_operations()), _keywords(_operations())),
            _section("Functions", functions(), _forms(known_functions()), _keywords(known_functions())),
            _section("Shape attributes", attributes(), known_attributes(), {}),
            _words(),
        )
    )


def _operations() -> Signatures:
    return {**known_operations(), **known_blocks()}


def _forms(signatures: Signatures) -> dict[str, str]:
    return {name: "<br>".join(_form(each) for each in forms) for name, forms in signatures.items()}


def _form(signature: Signature) -> str:
    arguments = ", ".join(
        "\\|".join(kind.removeprefix("$") for kind in parameter.types) + "?" * parameter.optional
        for parameter in signature.parameters
    )
    block = "" if signature.heads is None else " { … }"
    result = f" → {'|'.join(signature.result)}".replace("|", "\\|") if signature.result else ""
    return f"`{signature.name}({arguments}){block}{result}`".replace("\\|", " or ")


def _keywords(signatures: Signatures) -> dict[str, str]:
    """Keywords of each operation that are not supported."""
    lacking = {}
    for name, forms in signatures.items():
        sets = {
            kind[1:] for form in forms for parameter in form.parameters for kind in parameter.types if kind[0] == "$"
        }
        sets |= {form.heads for form in forms if form.heads is not None and form.heads in KEYWORDS}
        words = sorted({word for each in sets for word in KEYWORDS[each] if f"{name}:{word}" not in _WORDS})
        lacking[name] = ", ".join(f"`{word}`" for word in words)
    return lacking


def _section(title: str, support: Mapping[str, str], forms: Mapping[str, str], lacking: Mapping[str, str]) -> str:
    def row(name: str) -> str:
        without = f", without {lacking[name]}" if support[name] == YES and lacking.get(name) else ""
        return f"| `{name}` | {forms[name]} | {support[name]}{without} |"

    counted = f"{sum(each == YES for each in support.values())} of {len(support)} are supported."
    head = ["| name | forms | supported |" if lacking else "| name | type | supported |", "|---|---|---|"]
    return "\n".join([f"## {title}", "", counted, "", *head, *map(row, _sorted(support))])


def _words() -> str:
    rows = [f"| `{name}` | {' '.join(f'`{word}`' for word in sorted(KEYWORDS[name]))} |" for name in _sorted(KEYWORDS)]
    return "\n".join(["## Words", "", "| argument | is one of |", "|---|---|", *rows])


def _sorted(names: Iterable[str]) -> list[str]:
    return sorted(names, key=str.lower)
