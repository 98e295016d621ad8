"""Checks of expressions: known names and matching types."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from grammarlab.errors import Location
from grammarlab.language.checking.call_forms import check_arguments
from grammarlab.language.checking.percentages import check_percentages
from grammarlab.language.checking.symbols import Remarks, SupportedFeatures, Symbols, suggestion
from grammarlab.language.syntax import builtins
from grammarlab.language.syntax.keywords import (
    ANY,
    ARRAYS,
    BOOL,
    FLOAT,
    STRING,
    Scope,
    Types,
    advice,
    in_words,
    types_of,
)
from grammarlab.language.syntax.syntax_tree import (
    Array,
    Attribute,
    Binary,
    Boolean,
    Call,
    Case,
    Choice,
    Components,
    Expression,
    Floating,
    Function,
    Index,
    Name,
    Number,
    Relative,
    Span,
    Stochastic,
    String,
    Unary,
)
from grammarlab.language.syntax.syntax_tree import Sequence as Operations


class ExpressionChecker:
    """Infers the types of expressions and reports their errors."""

    def __init__(self, symbols: Symbols, supported: SupportedFeatures, remarks: Remarks) -> None:
        self.symbols = symbols
        self.supported = supported
        self.remarks = remarks
        self._types: dict[tuple[str, int], Types] = {}
        """Types of definitions, by name and number of parameters (-1 for attributes)."""

    def condition(self, node: Expression, scope: Scope) -> None:
        """Check the condition after ``case``."""
        self._expect(node, BOOL, "a condition", scope)

    def value(self, choice: Choice, scope: Scope) -> Types:
        """Types of the value of a function, attribute or argument."""
        if isinstance(choice, Operations):
            self.remarks.error("not-a-value", choice.location, "expected an expression, found operations")
            return ANY
        if not isinstance(choice, Case | Stochastic):
            return self.types(choice, scope)
        self.heads(choice, scope)
        if isinstance(choice, Case) and choice.conditions[-1] is not None:
            message = "expected an 'else' at the end of the cases: a value is needed in every case"
            self.remarks.error("case-without-else", choice.location, message, "add else : …")
        common_types: Types = frozenset()
        for branch in choice.branches:
            types = self.value(branch, scope)
            if common_types and not common_types & types:
                message = f"expected {in_words(common_types)} as in the branch before, found {in_words(types)}"
                self.remarks.error("mixed-types", branch.location, message, "all branches must be of one type")
                return ANY
            common_types = common_types & types if common_types else types
        return common_types

    def heads(self, choice: Case | Stochastic, scope: Scope) -> None:
        """Check the conditions or percentages of a choice."""
        if isinstance(choice, Case):
            for condition in choice.conditions:
                if condition is not None:
                    self.condition(condition, scope)
            return
        for percentage in choice.percentages:
            if percentage is not None:
                self._expect(percentage, FLOAT, "a percentage", scope)
        check_percentages(choice, self.remarks)

    def types(self, node: Expression, scope: Scope) -> Types:
        """Possible types of an expression."""
        literal = _LITERALS.get(type(node))
        return literal if literal is not None else _CHECKS[type(node)](self, node, scope)

    def _span(self, node: Span, scope: Scope) -> Types:
        for part in (node.first, node.last, node.step):
            if part is not None:
                self._expect(part, FLOAT, "a bound of a span", scope)
        return frozenset({"float[]"})

    def _expect(self, node: Expression, expected: Types, subject: str, scope: Scope) -> None:
        actual = self.types(node, scope)
        if not actual & expected:
            message = f"expected {in_words(expected)} for {subject}, found {in_words(actual)}"
            self.remarks.error("wrong-type", node.location, message, advice(expected, actual))

    # Names

    def name(self, node: Name, scope: Scope) -> Types:
        """Types of the value of a name."""
        name = node.identifier
        if name in scope.locals:
            return ANY
        if name in scope.selectors:
            return BOOL
        if name in self.symbols.attributes or name in self.symbols.functions:
            return self._defined(name, 0 if name in self.symbols.functions else -1, node.location)
        if name in builtins.attributes():
            subject = f"the shape attribute {name}"
            self.remarks.unsupported(self.supported.attributes, name, node.location, subject)
            return frozenset({builtins.attributes()[name]})
        if name in builtins.functions():
            return self._builtin(name, (), node.location, scope)
        library = self.symbols.library_of(name)
        if library is not None:
            symbols = library.symbols
            if symbols is not None and not symbols.is_value(library.rest):
                values = (*symbols.attributes, *symbols.functions)
                self._unknown(node, [f"{library.alias}.{value}" for value in values])
            return ANY
        if name not in self.symbols.broken:
            defined = (*scope.locals, *scope.selectors, *self.symbols.attributes, *self.symbols.functions)
            self._unknown(node, (*defined, *builtins.attributes(), *builtins.functions()))
        return ANY

    def _unknown(self, node: Name, valid_names: Sequence[str]) -> None:
        message = f"unknown name '{node.identifier}'"
        self.remarks.error("unknown-name", node.location, message, suggestion(node.identifier, valid_names))

    def _defined(self, name: str, num_arguments: int, location: Location) -> Types:
        """Types of an attribute (`num_arguments` -1), or of a call of a function of the file."""
        overloads = self.symbols.functions.get(name, {})
        if num_arguments == 0 and 0 not in overloads and name in self.symbols.attributes:
            num_arguments = -1
        definition: Attribute | Function | None
        definition = self.symbols.attributes.get(name) if num_arguments == -1 else overloads.get(num_arguments)
        if definition is None:
            arities = " or ".join(map(str, sorted(overloads)))
            message = f"{name} takes {arities} arguments, found {max(num_arguments, 0)}"
            self.remarks.error("wrong-arity", location, message)
            return ANY
        key = (name, num_arguments)
        if key not in self._types:
            self._types[key] = ANY  # assumed type of a recursive definition during its own inference
            silent = ExpressionChecker(self.symbols, self.supported, Remarks())
            silent._types = self._types
            parameters = definition.parameters if isinstance(definition, Function) else ()
            variables = tuple(variable.name for variable in definition.variables)
            self._types[key] = silent.value(definition.value, Scope(frozenset(parameters + variables)))
        return self._types[key]

    def _call(self, node: Call, scope: Scope) -> Types:
        if node.function in self.symbols.functions:
            for argument in node.arguments:
                self.value(argument, scope.plain())
            return self._defined(node.function, len(node.arguments), node.location)
        if node.function in builtins.functions():
            return self._builtin(node.function, node.arguments, node.location, scope)
        for argument in node.arguments:
            self.value(argument, scope.plain())
        library = self.symbols.library_of(node.function)
        if library is not None:
            if library.symbols is not None and library.rest not in library.symbols.functions:
                library_functions = [f"{library.alias}.{name}" for name in library.symbols.functions]
                self._unknown_function(node, library_functions)
            return ANY
        if node.function not in self.symbols.broken:
            self._unknown_function(node, (*self.symbols.functions, *builtins.functions()))
        return ANY

    def _unknown_function(self, node: Call, valid_names: Sequence[str]) -> None:
        message = f"unknown function '{node.function}'"
        self.remarks.error("unknown-function", node.location, message, suggestion(node.function, valid_names))

    def _builtin(self, name: str, arguments: Sequence[Expression], location: Location, scope: Scope) -> Types:
        self.remarks.unsupported(self.supported.functions, name, location, f"the function {name}")
        forms = builtins.functions()[name]
        form = check_arguments(self, name, forms, arguments, location, scope)
        results = frozenset().union(*(types_of(form.result) for form in ((form,) if form else forms)))
        if results & ARRAYS and results - ARRAYS and "any" not in forms[0].result and arguments:
            first_types = self._silently(arguments[0], scope)
            return (
                results & ARRAYS if first_types <= ARRAYS else results - ARRAYS if not first_types & ARRAYS else results
            )
        return results

    def _silently(self, node: Expression, scope: Scope) -> Types:
        silent = ExpressionChecker(self.symbols, self.supported, Remarks())
        silent._types = self._types
        return silent.types(node, scope.plain())

    # Operators

    def _unary(self, node: Unary, scope: Scope) -> Types:
        if node.operator.startswith("."):
            self.remarks.unsupported(self.supported.constructs, "element-wise", node.location, node.operator)
            return self.types(node.operand, scope)
        types = BOOL if node.operator == "!" else FLOAT
        self._expect(node.operand, types, f"'{node.operator}'", scope)
        return types

    def _binary(self, node: Binary, scope: Scope) -> Types:
        operator = node.operator
        if operator.startswith("."):
            self.remarks.unsupported(self.supported.constructs, "element-wise", node.location, operator)
            self.types(node.left, scope)
            self.types(node.right, scope)
            return ARRAYS
        if operator in ("&&", "||"):
            self._expect(node.left, BOOL, f"'{operator}'", scope)
            self._expect(node.right, BOOL, f"'{operator}'", scope)
            return BOOL
        if operator in ("-", "*", "/", "%"):
            self._expect(node.left, FLOAT, f"'{operator}'", scope)
            self._expect(node.right, FLOAT, f"'{operator}'", scope)
            return FLOAT
        left, right = self.types(node.left, scope), self.types(node.right, scope)
        if operator == "+":
            return self._plus(node, left, right)
        comparable = left & right if operator in ("==", "!=") else left & right - {"bool", "bool[]"}
        if not comparable:
            message = f"'{operator}' cannot compare {in_words(left)} with {in_words(right)}"
            self.remarks.error("wrong-type", node.location, message, advice(left, right))
        return BOOL

    def _plus(self, node: Binary, left: Types, right: Types) -> Types:
        result: Types = frozenset()
        if "string" in left | right:
            result |= STRING
        if "float" in left & right:
            result |= FLOAT
        if not result:
            message = f"'+' adds numbers or joins strings, found {in_words(left)} and {in_words(right)}"
            self.remarks.error("wrong-type", node.location, message)
            return ANY
        return STRING if STRING in (left, right) else result

    def _size(self, node: Relative | Floating, scope: Scope) -> Types:
        is_allowed, sign = (scope.relative, "'") if isinstance(node, Relative) else (scope.floating, "~")
        if not is_allowed:
            contexts = "in the sizes of operations and splits" if sign == "'" else "at the head of a part of a split"
            self.remarks.error("misplaced-size", node.location, f"{sign} is allowed only {contexts}")
        self._expect(node.operand, FLOAT, "a size", replace(scope, floating=False))
        return FLOAT

    # Arrays

    def _array(self, node: Array, scope: Scope) -> Types:
        self.remarks.unsupported(self.supported.constructs, "array", node.location, "an array")
        cell_types = ANY - ARRAYS
        for cell in (cell for row in node.rows for cell in row):
            types = frozenset(kind.removesuffix("[]") for kind in self.types(cell, scope.plain()))
            if not cell_types & types:
                message = f"expected {in_words(cell_types)} as in the cells before, found {in_words(types)}"
                self.remarks.error("mixed-types", cell.location, message, "all cells must be of one type")
                return ARRAYS
            cell_types &= types
        return frozenset(f"{kind}[]" for kind in cell_types)

    def _index(self, node: Index, scope: Scope) -> Types:
        array = self.types(node.array, scope.plain())
        if not array & ARRAYS:
            message = f"expected an array before '[', found {in_words(array)}"
            self.remarks.error("wrong-type", node.location, message)
        for index in node.indices:
            self.types(index, scope.plain())
        arrays = array & ARRAYS or ARRAYS
        return arrays | {kind.removesuffix("[]") for kind in arrays}

    def _components(self, node: Components, scope: Scope) -> Types:
        self.remarks.unsupported(self.supported.constructs, "comp-function", node.location, "comp as a function")
        form = check_arguments(self, "comp", builtins.blocks()["comp"], node.arguments, node.location, scope)
        selectors = builtins.KEYWORDS[form.heads] if form and form.heads else frozenset[str]()
        part_types = ANY - ARRAYS
        for part in node.parts:
            self.types(part.head, replace(scope.plain(), selectors=selectors))
            part_types &= self.value(part.body, scope.plain())
        return frozenset(f"{kind}[]" for kind in part_types or ANY - ARRAYS)


_LITERALS: dict[type, Types] = {Number: FLOAT, String: STRING, Boolean: BOOL}
_CHECKS: dict[type, Callable[[ExpressionChecker, Any, Scope], Types]] = {
    Name: ExpressionChecker.name,
    Call: ExpressionChecker._call,
    Unary: ExpressionChecker._unary,
    Binary: ExpressionChecker._binary,
    Relative: ExpressionChecker._size,
    Floating: ExpressionChecker._size,
    Index: ExpressionChecker._index,
    Array: ExpressionChecker._array,
    Span: ExpressionChecker._span,
    Components: ExpressionChecker._components,
    Case: ExpressionChecker.value,
    Stochastic: ExpressionChecker.value,
}
