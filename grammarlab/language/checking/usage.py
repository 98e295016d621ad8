"""Checks of sequences of operations: known operations, and calls that match the parameters of rules."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from grammarlab.language.checking.call_forms import check_arguments, note_keyword
from grammarlab.language.checking.inference import ExpressionChecker
from grammarlab.language.checking.percentages import constant
from grammarlab.language.checking.symbols import Library, suggestion
from grammarlab.language.syntax import builtins
from grammarlab.language.syntax.keywords import FLOAT, Scope, in_words
from grammarlab.language.syntax.syntax_tree import (
    Attribute,
    Block,
    Case,
    Choice,
    Expression,
    Floating,
    Group,
    Inline,
    Invoke,
    Item,
    Name,
    Part,
    Relative,
    Rule,
    Scatter,
    Scoped,
    Stochastic,
)
from grammarlab.language.syntax.syntax_tree import Sequence as Operations


class BodyChecker:
    """Checks the bodies of rules."""

    def __init__(self, expressions: ExpressionChecker) -> None:
        self.expressions = expressions
        self.symbols = expressions.symbols
        self.supported = expressions.supported
        self.remarks = expressions.remarks
        self._rules = frozenset(name.lower() for name in self.symbols.rules)
        self._operations = frozenset(name.lower() for name in (*builtins.operations(), *builtins.blocks()))

    def body(self, choice: Choice, scope: Scope) -> None:
        """Check the body of a rule, or of a part of a block."""
        if isinstance(choice, Operations):
            for item in choice.items:
                self._item(item, scope)
        elif isinstance(choice, Case | Stochastic):
            self.expressions.heads(choice, scope)
            if isinstance(choice, Case) and choice.conditions[-1] is not None:
                message = "these cases have no 'else': a shape that matches none of them ends here"
                self.remarks.warning("case-without-else", choice.location, message, "add else : NIL, or another branch")
            for branch in choice.branches:
                self.body(branch, scope)
        else:
            self.remarks.error("not-operations", choice.location, "expected operations, found an expression")

    def _item(self, item: Item, scope: Scope) -> None:
        match item:
            case Invoke():
                self._invoke(item, scope)
            case Block():
                self._block(item, scope)
            case Scoped():
                self.body(item.body, scope)
            case Scatter():
                self.remarks.unsupported(self.supported.operations, "scatter", item.location, "the operation scatter")
                forms = builtins.blocks()["scatter"]
                check_arguments(self.expressions, "scatter", forms, item.arguments, item.location, scope)
                self.body(item.body, scope)
            case Inline():
                self._inline(item, scope)

    def _inline(self, item: Inline, scope: Scope) -> None:
        subject = "inline" if item.operation == "inline" else f"the operation {item.operation}"
        self.remarks.unsupported(self.supported.operations, item.operation, item.location, subject)
        strategies = builtins.KEYWORDS["merge" if item.operation == "inline" else "swap"]
        if item.strategy and item.strategy not in strategies:
            message = f"{item.operation} expects one of {', '.join(sorted(strategies))}, found '{item.strategy}'"
            self.remarks.error("unknown-keyword", item.location, message, suggestion(item.strategy, strategies))
        self.body(item.body, scope)
        if item.second is not None:
            self.body(item.second, scope)

    # Symbols and operations without a block

    def _invoke(self, item: Invoke, scope: Scope) -> None:
        name = item.name
        if name in builtins.operations():
            if name in self.supported.harmless:
                self.remarks.left_out(item.location, f"the operation {name}")
            else:
                self.remarks.unsupported(self.supported.operations, name, item.location, f"the operation {name}")
            forms = builtins.operations()[name]
            if self._means_shadowed_rule(item):
                message = f"{name} is an operation here, not the rule {name} of this file"
                hint = f"give the rule another name, such as {name[0].upper()}{name[1:]}, here and where it is defined"
                self.remarks.error("shadowed-rule", item.location, message, hint)
            else:
                check_arguments(self.expressions, name, forms, item.arguments, item.location, scope)
            return
        arities = self.symbols.rules.get(name)
        if arities is None and name in builtins.blocks():
            message = f"{name} needs a block"
            self.remarks.error("missing-block", item.location, message, f"write {name}(…) {{ … : … | … : … }}")
            return
        for argument in item.arguments:
            self.expressions.value(argument, scope.plain())
        if item.overrides is not None:
            self._dynamic_import(item, scope)
        if arities is not None:
            if len(item.arguments) not in arities:
                counts = " or ".join(map(str, sorted(arities)))
                message = f"the rule {name} takes {counts} arguments, found {len(item.arguments)}: the shape ends here"
                self.remarks.warning("wrong-arity", item.location, message, f"or write a rule {_headline(item)} --> …")
            return
        library = self.symbols.library_of(name)
        if library is not None:
            self._library_rule(item, library)
        elif name not in self.symbols.broken:
            self._terminal(item)

    def _means_shadowed_rule(self, item: Invoke) -> bool:
        """Whether the arguments fit a rule with the name of an operation, and no form of the operation."""
        count = len(item.arguments)
        fits_operation = any(form.takes(count) for form in builtins.operations()[item.name])
        return count in self.symbols.rules.get(item.name, ()) and not fits_operation

    def _library_rule(self, item: Invoke, library: Library) -> None:
        if library.symbols is None:
            return
        arities = library.symbols.rules.get(library.rest)
        if arities is None:
            message = f"the import {library.alias} has no rule {library.rest}"
            valid_names = [f"{library.alias}.{rule}" for rule in library.symbols.rules]
            self.remarks.error("unknown-name", item.location, message, suggestion(item.name, valid_names))
        elif len(item.arguments) not in arities:
            counts = " or ".join(map(str, sorted(arities)))
            message = f"the rule {item.name} takes {counts} arguments, found {len(item.arguments)}"
            self.remarks.error("wrong-arity", item.location, message)

    def _terminal(self, item: Invoke) -> None:
        """A symbol without a rule ends the derivation; warn if it looks like a typing error."""
        if item.name.endswith("."):
            return
        folded = item.name.lower()
        # Symbols begin with a capital by custom, operations never do.
        slip = folded in self._rules or (item.name[0].islower() and folded in self._operations)
        if item.parenthesised or slip:
            valid_names = (*self.symbols.rules, *builtins.operations(), *builtins.blocks())
            message = f"unknown rule or operation '{item.name}': it ends the derivation here"
            self.remarks.warning("unknown-symbol", item.location, message, suggestion(item.name, valid_names))

    def _dynamic_import(self, item: Invoke, scope: Scope) -> None:
        if any(isinstance(override, Rule) for override in item.overrides or ()):
            subject = "redefining a rule at an imported rule's call"
            self.remarks.unsupported(self.supported.constructs, "dynamic-import", item.location, subject)
        for override in item.overrides or ():
            if isinstance(override, Rule):
                parameters = scope.locals | frozenset(override.parameters)
                self.body(override.body, replace(scope, locals=parameters))
            else:
                self.expressions.value(override.value, scope.plain())
                self._redefined(item, override)

    def _redefined(self, item: Invoke, override: Attribute) -> None:
        """Report a value for what is no attribute of the file that an imported rule is in."""
        path = item.name.rpartition(".")[0]
        library = self.symbols.library_of(item.name)
        # In a linked file the definitions of an import have its name before theirs.
        symbols, rule = (self.symbols, item.name) if library is None else (library.symbols, library.rest)
        prefix = rule[: rule.rfind(".") + 1]
        name = prefix + override.name
        is_broken = not self.symbols.broken.isdisjoint({name, path.partition(".")[0]})
        if symbols is None or name in symbols.attributes or is_broken:
            return
        valid_names = [known.removeprefix(prefix) for known in symbols.attributes if known.startswith(prefix)]
        message = f"the import {path} has no attribute {override.name}"
        hint = suggestion(override.name, valid_names) or "a call of an imported rule redefines attributes only"
        self.remarks.error("unknown-name", override.location, message, hint)

    # Blocks

    def _block(self, item: Block, scope: Scope) -> None:
        forms = builtins.blocks().get(item.name, ())
        if not forms:
            operations = builtins.operations()
            if item.name in operations:
                message, hint = f"the operation {item.name} takes no block", ""
            else:
                message = f"unknown operation with a block '{item.name}'"
                hint = suggestion(item.name, builtins.blocks())
            self.remarks.error("unknown-operation", item.location, message, hint)
        else:
            self.remarks.unsupported(self.supported.operations, item.name, item.location, f"the operation {item.name}")
        inner = replace(scope, relative=True) if item.name.startswith("setback") else scope
        form = (
            check_arguments(self.expressions, item.name, forms, item.arguments, item.location, inner) if forms else None
        )
        heads = form.heads if form is not None else forms[0].heads if forms else None
        if heads == "size":
            self._sizes(item.group, scope)
        else:
            self._selectors(item, item.group, heads, scope)
        if item.remainder is not None:
            self._selectors(item, item.remainder, "remainder_selector", scope)

    def _sizes(self, group: Group, scope: Scope) -> None:
        for part in group.parts:
            if isinstance(part, Group):
                self._sizes(part, scope)
                continue
            if part.inclusive or part.connected:
                message = "expected ':' between a size and its operations"
                self.remarks.error("wrong-separator", part.location, message, "write size : operations")
            self._size(part.head, scope)
            if part.depth is not None:
                self.expressions.types(part.depth, replace(scope.plain(), relative=True))
            self.body(part.body, scope)

    def _size(self, head: Expression, scope: Scope) -> None:
        types = self.expressions.types(head, replace(scope.plain(), relative=True, floating=True))
        if not types & FLOAT:
            message = f"expected a size, found {in_words(types)}"
            self.remarks.error("wrong-type", head.location, message)
        value = head
        while isinstance(value, Relative | Floating):
            value = value.operand
        number = constant(value)
        if number is not None and not number > 0:
            message = f"a part of size {number:g} is never made"
            self.remarks.warning("empty-part", head.location, message, "expected a size above 0")

    def _selectors(self, item: Block, group: Group, heads: str | None, scope: Scope) -> None:
        words = builtins.KEYWORDS[heads] if heads is not None else frozenset[str]()
        if group.repeated:
            self.remarks.error("misplaced-star", group.location, f"{item.name} does not repeat: '*' belongs to splits")
        for part in group.parts:
            if isinstance(part, Group):
                message = f"expected 'selector : operations' in {item.name}, found braces"
                self.remarks.error("misplaced-group", part.location, message, "only splits have braces inside braces")
                continue
            if part.connected:
                self.remarks.unsupported(self.supported.constructs, "connected", part.location, "'=:'")
            self._selector(item, part, words, scope)
            self.body(part.body, scope)

    def _selector(self, item: Block, part: Part, words: frozenset[str], scope: Scope) -> None:
        head = part.head
        if not words:
            return
        if not isinstance(head, Name):
            self.expressions.types(head, replace(scope.plain(), selectors=words))
        elif head.identifier in words:
            note_keyword(self.expressions, item.name, head)
        elif not self._has_value(head.identifier, scope):
            message = f"{item.name} has no selector '{head.identifier}'"
            hint = suggestion(head.identifier, words) or f"expected one of {', '.join(_shortest(words))}, …"
            self.remarks.error("unknown-selector", head.location, message, hint)

    def _has_value(self, name: str, scope: Scope) -> bool:
        library = self.symbols.library_of(name)
        is_value = name in scope.locals or self.symbols.is_value(name) or name in builtins.attributes()
        return is_value or library is not None or name in self.symbols.broken or name in builtins.functions()


def _headline(item: Invoke) -> str:
    return f"{item.name}({', '.join('abcdefghijklmnopqrstuvwxyz'[: len(item.arguments)])})"


def _shortest(words: Sequence[str] | frozenset[str]) -> list[str]:
    return sorted(words, key=lambda word: ("." in word, word))[:8]
