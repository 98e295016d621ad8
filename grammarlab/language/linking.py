"""A rule file and its imports merged into the text of one rule file.

Definitions of a file imported as ``st`` get the prefix ``st.``, and so do the symbols that its rules make. An imported
attribute takes the value of the importing file's attribute of the same name, unless the import protects it or
gives it another value; `CGA reference, import`. If the importing file defines a rule ``st.Facade``, that rule replaces
the imported one. ``import st(Tall) : …`` takes the style ``Tall`` of the file; otherwise styles are dropped.

Imports that cannot be read are kept, so that the checker and derivations report them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import TypeVar

from grammarlab.errors import Finding, LanguageError
from grammarlab.language.formatting import format_grammar
from grammarlab.language.grammar import Grammar, default_style
from grammarlab.language.styles import styled
from grammarlab.language.syntax.builtins import Signature, attributes, blocks, functions, operations
from grammarlab.language.syntax.keywords import KEYWORDS
from grammarlab.language.syntax.printing import import_statement
from grammarlab.language.syntax.syntax_tree import (
    Annotation,
    Attribute,
    Block,
    Call,
    Definition,
    Expression,
    Function,
    Group,
    Import,
    Invoke,
    Name,
    Node,
    Rule,
    RuleFile,
    Scatter,
    Style,
    walk,
)

MAX_COPIES = 200
"""Largest number of copies of imported files; a file imported under several names has one copy per name."""

_BUILTIN = frozenset(functions()) | frozenset(attributes())
_Node = TypeVar("_Node", bound=Node)


def linked(grammar: Grammar) -> str:
    """Text of an equivalent rule file without imports.

    The text of the importing file keeps its lines; the imported text follows, before its first style.

    Args:
        grammar: a grammar from `grammarlab.language.importing.load`.

    Raises:
        LanguageError: If there are too many imported files, or a number that CGA cannot express.
    """
    tree = grammar.tree
    if not any(isinstance(definition, Import) for definition in tree.definitions):
        return grammar.text
    linker = _Linker()
    scope = _Scope("", grammar, {})
    linker.taken |= {_key(definition) for definition in tree.definitions}
    parts: list[str] = []
    text = grammar.text
    for definition, (start, end) in zip(tree.definitions, tree.spans, strict=True):
        if isinstance(definition, Import) and grammar.libraries.get(definition.alias) is not None:
            parts += linker.library(definition, scope)
            text = text[:start] + "".join(c if c.isspace() else " " for c in text[start:end]) + text[end:]
    styles = (span[0] for node, span in zip(tree.definitions, tree.spans, strict=True) if isinstance(node, Style))
    end = next(styles, len(text))
    return f"{text[:end].rstrip()}\n\n{''.join(parts)}\n{text[end:]}".rstrip() + "\n"


@dataclass(frozen=True)
class _Scope:
    """An imported file under its alias."""

    prefix: str
    """Prefix of the names of its definitions: empty, or ``st.``."""
    grammar: Grammar
    handed: Mapping[str, str]
    """Full names of the attributes of importing files, by the plain names of the attributes that take their values."""

    def full(self, name: str, local: frozenset[str] = frozenset()) -> str:
        """Full name of an attribute, constant or function."""
        if name in local:
            return name
        is_defined_here = name in self._names or (
            name.partition(".")[0] in self.grammar.imports and name not in _BUILTIN
        )
        return self.prefix + name if is_defined_here else name

    @cached_property
    def _names(self) -> frozenset[str]:
        return frozenset(self.grammar.attributes) | {name for name, _ in self.grammar.functions}

    def handed_on(self, statement: Import) -> dict[str, str]:
        """Attributes of this file that an imported file takes its values from."""
        if statement.protected is None:
            return {}
        own_attributes = {
            attribute.name: self.prefix + attribute.name
            for attribute in self.grammar.attributes.values()
            if not attribute.constant and not _mentions(attribute, f"{statement.alias}.{attribute.name}")
        }
        excluded = {*statement.protected, *(name for name, _ in statement.arguments)}
        return {name: full for name, full in {**self.handed, **own_attributes}.items() if name not in excluded}


class _Linker:
    """Writes imported files, each with its own prefix."""

    def __init__(self) -> None:
        self.taken: set[tuple[type, str, int]] = set()
        """Existing definitions: kind, full name, number of parameters."""
        self.copies = 0

    def library(self, statement: Import, importer: _Scope) -> Iterator[str]:
        """Text of an imported file and of its imports."""
        library = importer.grammar.libraries[statement.alias]
        if library is None:
            values = tuple((name, _renamed(value, importer)) for name, value in statement.arguments)
            rules = tuple(_bodies(statement.rules, importer))
            full = replace(statement, alias=importer.prefix + statement.alias, arguments=values, rules=rules)
            yield import_statement(full) + "\n"
            return
        self.copies += 1
        if self.copies > MAX_COPIES:
            raise _unlinkable(f"expected at most {MAX_COPIES} copies of imported files", statement)
        for style in statement.styles[:1]:
            library = styled(library, style)
        scope = _Scope(f"{importer.prefix}{statement.alias}.", library, importer.handed_on(statement))
        values_by_name = dict(statement.arguments)
        extensions = [replace(rule, name=scope.prefix + rule.name) for rule in _bodies(statement.rules, importer)]
        definitions = [
            *(rule for rule in extensions if self._takes(rule)),
            *(
                d
                for definition in default_style(library.tree)
                for d in self._definition(definition, scope, values_by_name, importer)
            ),
        ]
        yield f"\n// {' '.join(statement.path.split())} as {scope.prefix.rstrip('.')}\n"
        try:
            yield format_grammar(RuleFile("", tuple(definitions)))
        except ValueError as error:
            raise _unlinkable(f"'{statement.path}' cannot be written as text: {error}", statement) from error
        for definition in default_style(library.tree):
            if isinstance(definition, Import):
                yield from self.library(definition, scope)

    def _definition(
        self, node: Definition, scope: _Scope, values: Mapping[str, Expression], importer: _Scope
    ) -> Iterator[Definition]:
        if isinstance(node, Import | Style):
            return
        full = replace(node, name=scope.prefix + node.name, annotations=_annotations(node))
        if isinstance(full, Rule):
            full = replace(full, keyword="")
        if not self._takes(full):
            return
        if isinstance(node, Attribute) and not node.constant and node.name in values:
            yield replace(full, value=_renamed(values[node.name], importer))
        elif isinstance(node, Attribute) and not node.constant and node.name in scope.handed:
            yield replace(full, value=Name(scope.handed[node.name], location=node.location))
        else:
            local = () if isinstance(node, Attribute) else node.parameters
            names = frozenset((*local, *(variable.name for variable in node.variables)))
            yield _below(full, scope, names)

    def _takes(self, definition: Definition) -> bool:
        key = _key(definition)
        new = key not in self.taken
        self.taken.add(key)
        return new


def _key(definition: Definition) -> tuple[type, str, int]:
    name = definition.alias if isinstance(definition, Import) else definition.name
    count = len(definition.parameters) if isinstance(definition, Rule | Function) else 0
    return Rule if isinstance(definition, Rule) else Node, name, count


def _annotations(node: Attribute | Function | Rule) -> tuple[Annotation, ...]:
    """The rule without its start mark: only the importing file defines start rules."""
    return tuple(mark for mark in node.annotations if mark.name.lower() != "startrule")


def _bodies(rules: tuple[Rule, ...], scope: _Scope) -> Iterator[Rule]:
    for rule in rules:
        yield replace(_below(rule, scope, frozenset(rule.parameters)), keyword="", annotations=())


def _mentions(node: Node, name: str) -> bool:
    return any(isinstance(inner, Name) and inner.identifier == name for inner in walk(node))


def _unlinkable(message: str, statement: Import) -> LanguageError:
    return LanguageError((Finding("error", "bad-import", message, statement.location),))


# Names in expressions and operations ------------------------------------------------------------------------


def _renamed(node: _Node, scope: _Scope, local: frozenset[str] = frozenset()) -> _Node:
    """Part of the tree with full names of the file's definitions, except for names in `local`."""
    match node:
        case Name():
            return replace(node, identifier=scope.full(node.identifier, local))
        case Call():
            forms = functions().get(node.function, ())
            return replace(
                node, function=scope.full(node.function), arguments=_arguments(node.arguments, forms, scope, local)
            )
        case Invoke():
            forms = operations().get(node.name, ())
            name = node.name if forms or node.name in blocks() else scope.prefix + node.name
            renamed = _below(node, scope, local, "arguments")
            return replace(renamed, name=name, arguments=_arguments(node.arguments, forms, scope, local))
        case Block():
            forms = blocks().get(node.name, ())
            words = frozenset[str]().union(*(KEYWORDS.get(form.heads or "", frozenset()) for form in forms))
            renamed = _below(node, scope, local, "arguments", "group")
            arguments = _arguments(node.arguments, forms, scope, local)
            return replace(renamed, arguments=arguments, group=_group(node.group, words, scope, local))
        case Scatter():
            arguments = _arguments(node.arguments, blocks()["scatter"], scope, local)
            return replace(_below(node, scope, local, "arguments"), arguments=arguments)
    return _below(node, scope, local)


def _below(node: _Node, scope: _Scope, local: frozenset[str], *without: str) -> _Node:
    """A node with full names below it, except in some of its fields."""
    names = [field.name for field in fields(node) if field.name not in without]
    return replace(node, **{name: _all(getattr(node, name), scope, local) for name in names})


def _all(value: object, scope: _Scope, local: frozenset[str]) -> object:
    if isinstance(value, Annotation):
        return value
    if isinstance(value, Node):
        return _renamed(value, scope, local)
    return tuple(_all(item, scope, local) for item in value) if isinstance(value, tuple) else value


def _arguments(
    arguments: tuple[Expression, ...], forms: tuple[Signature, ...], scope: _Scope, local: frozenset[str]
) -> tuple[Expression, ...]:
    """Arguments with full names, except for keywords of the operation or function."""
    fitting = [form for form in forms if form.takes(len(arguments))]
    words = [frozenset[str]().union(*(form.parameters[i].keywords for form in fitting)) for i in range(len(arguments))]
    return tuple(
        argument if isinstance(argument, Name) and argument.identifier in keywords else _renamed(argument, scope, local)
        for argument, keywords in zip(arguments, words, strict=True)
    )


def _group(group: Group, words: frozenset[str], scope: _Scope, local: frozenset[str]) -> Group:
    """Parts with full names, except for the selectors before their colons."""
    parts = tuple(
        _group(part, words, scope, local)
        if isinstance(part, Group)
        else replace(_below(part, scope, local, "head"), head=_renamed(part.head, scope, local | words))
        for part in group.parts
    )
    return replace(group, parts=parts)
