"""Checks of the arguments of CGA's operations and functions against the forms in its tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

from grammarlab.errors import Location
from grammarlab.language.checking.symbols import Remarks, SupportedFeatures, Symbols, suggestion
from grammarlab.language.syntax import builtins
from grammarlab.language.syntax.builtins import Parameter, Signature
from grammarlab.language.syntax.keywords import ANY, STRING, Scope, Types, advice, in_words, types_of
from grammarlab.language.syntax.syntax_tree import Call, Choice, Expression, Name, String


class Checker(Protocol):
    """Infers the types of arguments and reports their errors."""

    symbols: Symbols
    supported: SupportedFeatures
    remarks: Remarks

    def value(self, choice: Choice, scope: Scope) -> Types:
        """Types of an argument."""
        ...

    def name(self, node: Name, scope: Scope) -> Types:
        """Types of the value of a name."""
        ...


def check_arguments(
    checker: Checker,
    name: str,
    forms: Sequence[Signature],
    arguments: Sequence[Expression],
    location: Location,
    scope: Scope,
) -> Signature | None:
    """Check the arguments of an operation or function; returns the matching form, if any."""
    candidates = [form for form in forms if form.takes(len(arguments))]
    if not candidates:
        for argument in arguments:
            if not isinstance(argument, Name):
                checker.value(argument, replace(scope, relative=True, floating=True))
        message = f"{name} takes {_counts(forms)}, found {len(arguments)}"
        checker.remarks.error("wrong-arity", location, message, f"write {' or '.join(map(_signature_text, forms))}")
        return None
    types = [
        _argument(checker, argument, [form.parameters[i] for form in candidates], scope)
        for i, argument in enumerate(arguments)
    ]
    misfits = {form: _misfit(form, arguments, types) for form in candidates}
    best = max(candidates, key=lambda form: len(arguments) if misfits[form] is None else misfits[form] or 0)
    misfit = misfits[best]
    if misfit is None:
        for argument, parameter in zip(arguments, best.parameters, strict=False):
            _note_keyword(checker, name, argument, parameter)
        return best
    expected = best.parameters[misfit]
    argument = arguments[misfit]
    if expected.keywords:
        choices = sorted(set().union(*(form.parameters[misfit].keywords for form in candidates)))
        actual = f"'{argument.identifier}'" if isinstance(argument, Name) else in_words(types[misfit] or ANY)
        message = f"{name} expects one of {', '.join(choices)} here, found {actual}"
        hint = suggestion(argument.identifier, choices) if isinstance(argument, Name) else ""
        checker.remarks.error("unknown-keyword", argument.location, message, hint)
    else:
        expected_types = types_of(expected.types)
        message = f"{name} expects {in_words(expected_types)} here, found {in_words(types[misfit] or ANY)}"
        hint = advice(expected_types, types[misfit] or ANY)
        checker.remarks.error("wrong-type", argument.location, message, hint)
    return None


def _argument(checker: Checker, node: Expression, parameters: Sequence[Parameter], scope: Scope) -> Types | None:
    """Types of an argument; None for a keyword, known or unknown."""
    takes_keyword = any(parameter.keywords for parameter in parameters)
    if isinstance(node, Name) and takes_keyword:
        is_value = node.identifier in scope.locals or checker.symbols.is_value(node.identifier)
        if any(node.identifier in parameter.keywords for parameter in parameters) or not (
            is_value or node.identifier in builtins.attributes()
        ):
            return None
    if any("place" in parameter.types for parameter in parameters):
        return _argument_to_set(checker, node, scope)
    kinds = {kind for parameter in parameters for kind in parameter.types}
    return checker.value(
        node, replace(scope.plain(), relative=bool(kinds & {"size", "tile"}), floating="tile" in kinds)
    )


def _argument_to_set(checker: Checker, node: Expression, scope: Scope) -> Types:
    """Check the name that ``set`` sets."""
    if isinstance(node, Call) and node.function == "sel":
        checker.value(node, scope.plain())
    elif not isinstance(node, Name):
        checker.remarks.error("wrong-type", node.location, "set expects the name of an attribute first")
    elif node.identifier in builtins.READ_ONLY_ATTRIBUTES:
        checker.remarks.error("read-only", node.location, f"{node.identifier} cannot be set")
    elif node.identifier in builtins.attributes():
        subject = f"the shape attribute {node.identifier}"
        if node.identifier in checker.supported.harmless:
            checker.remarks.left_out(node.location, subject)
        else:
            checker.remarks.unsupported(checker.supported.attributes, node.identifier, node.location, subject)
    elif node.identifier not in checker.symbols.attributes:
        checker.name(node, scope.plain())
    return ANY


def _misfit(form: Signature, arguments: Sequence[Expression], types: Sequence[Types | None]) -> int | None:
    """Index of the first argument that does not fit the form."""
    for index, (argument, argument_types) in enumerate(zip(arguments, types, strict=True)):
        parameter = form.parameters[index]
        if parameter.keywords:
            # A parameter of a rule may hold a selector that its caller made with sel(...): its type is unknown.
            # Quotes around a keyword are an older way to write it.
            quoted = isinstance(argument, String) and argument.value in parameter.keywords
            fits = quoted or (isinstance(argument, Name) and argument.identifier in parameter.keywords)
            # Text that an attribute or function gives may be a keyword.
            is_computed = argument_types == STRING and not isinstance(argument, String)
            if not fits and argument_types != ANY and not is_computed:
                return index
        elif argument_types is None or not argument_types & types_of(parameter.types):
            return index
    return None


def _note_keyword(checker: Checker, name: str, argument: Expression, parameter: Parameter) -> None:
    if isinstance(argument, Name) and argument.identifier in parameter.keywords:
        note_keyword(checker, name, argument)


def note_keyword(checker: Checker, name: str, word: Name) -> None:
    """Report unsupported keywords of an operation."""
    feature = f"{name}:{word.identifier}"
    checker.remarks.unsupported(checker.supported.keywords, feature, word.location, f"{name} with {word.identifier}")


def _counts(forms: Sequence[Signature]) -> str:
    counts = sorted({n for form in forms for n in range(form.fewest, len(form.parameters) + 1)})
    if counts == [0]:
        return "no arguments"
    if len(counts) > 2 and counts == list(range(counts[0], counts[-1] + 1)):
        return f"{counts[0]} to {counts[-1]} arguments"
    return f"{' or '.join(map(str, counts))} argument{'s' if counts != [1] else ''}"


def _signature_text(form: Signature) -> str:
    arguments = [("|".join(p.types).replace("$", "")) + ("?" if p.optional else "") for p in form.parameters]
    return f"{form.name}({', '.join(arguments)})"
