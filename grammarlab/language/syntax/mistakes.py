"""Findings for syntax errors: expected tokens, found token, and a hint."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from grammarlab.errors import Finding
from grammarlab.language.syntax.tokens import Token

_OPERAND = frozenset({"NUMBER", "STRING", "BOOLEAN", "PREFIX", "_LPAR"})
"""Token types that begin only expressions."""
_ITEM = frozenset({"NAME", "INLINE", "SCATTER"})
"""Token types that begin an operation."""
_SEPARATORS = frozenset({"_COLON", "_EQUALS", "_EQUALS_COLON"})

_WORDS = {
    "_ARROW": "'-->'",
    "_EQUALS": "'='",
    "_EQUALS_COLON": "'=:'",
    "_COLON": "':'",
    "_COMMA": "','",
    "_BAR": "'|'",
    "_SEMICOLON": "';'",
    "_LPAR": "'('",
    "RPAR": "')'",
    "_LBRACE": "'{'",
    "CLOSE": "'}'",
    "_LBRACKET": "'['",
    "RBRACKET": "']'",
    "_ASSIGN": "':='",
    "_ELSE": "'else'",
    "CASE": "'case'",
    "NAME": "a name",
    "STRING": "a string",
    "NUMBER": "a number",
    "MEMBER": "'.Rule'",
    "_AT": "an annotation",
    "ATTRIBUTE": "'attr'",
    "$END": "the end of the definition",
}


@dataclass(frozen=True, slots=True)
class _Error:
    """An unexpected token."""

    tokens: Sequence[Token]
    position: int
    expected: frozenset[str]

    @property
    def ended(self) -> bool:
        """Whether the definition ends too early."""
        return self.position >= len(self.tokens)

    @property
    def token(self) -> Token:
        """The unexpected token; the last token of a definition that ends too early."""
        return self.tokens[min(self.position, len(self.tokens) - 1)]

    @property
    def before(self) -> str:
        """Type of the previous token."""
        return self.tokens[self.position - 1].type if self.position else ""

    @property
    def after(self) -> str:
        """Type of the next token."""
        return self.tokens[self.position + 1].type if self.position + 1 < len(self.tokens) else ""

    def token_in_words(self) -> str:
        """The token in words."""
        if self.ended:
            return "the end of the definition"
        return "a percentage" if self.token.type == "CHANCE" else f"'{self.token.value}'"

    def in_condition(self) -> bool:
        """Whether the token stands between ``case`` and its colon."""
        for token in reversed(self.tokens[: self.position]):
            if token.type == "CASE":
                return True
            if token.type in ("_COLON", "_BAR", "_LBRACE"):
                return False
        return False

    def opening(self) -> str:
        """Type of the innermost open bracket at the token."""
        position = self._opening_position()
        return "" if position < 0 else self.tokens[position].type

    def merging(self) -> str:
        """``union``, ``inline``, … with their strategy if the token is directly in their braces; otherwise empty."""
        position = self._opening_position()
        before = self.tokens[position - 1] if position > 0 else None
        is_operand = before is not None and before.type == "INLINE" and self.opening() == "_LBRACE"
        return before.value if before is not None and is_operand else ""

    def _opening_position(self) -> int:
        """Index of the innermost open bracket at the token; -1 if there is none."""
        depth = 0
        for position in range(min(self.position, len(self.tokens)) - 1, -1, -1):
            kind = self.tokens[position].type
            if kind in ("RPAR", "CLOSE", "RBRACKET"):
                depth += 1
            elif kind in ("_LPAR", "_LBRACE", "_LBRACKET"):
                if depth == 0:
                    return position
                depth -= 1
        return -1


def explain(tokens: Sequence[Token], position: int, expected: frozenset[str]) -> Finding:
    """Finding for an unexpected token.

    Args:
        tokens: the tokens of the definition, at least one.
        position: index of the token; past the last token if the definition ends too early.
        expected: allowed token types.
    """
    error = _Error(tokens, position, expected)
    for recognise in _USUAL_MISTAKES:
        advice = recognise(error)
        if advice is not None:
            code, message, hint = advice
            return Finding("error", code, f"{message}, found {error.token_in_words()}", error.token.location, hint)
    message = f"expected {_in_words(expected)}, found {error.token_in_words()}"
    return Finding("error", "syntax", message, error.token.location)


def _in_words(expected: frozenset[str]) -> str:
    words: list[str] = []
    remaining = set(expected)
    if remaining >= {"NUMBER", "STRING"}:
        words.append("an expression")
        remaining -= _OPERAND | {"NAME", "SIGN", "_LBRACKET", "CASE", "CHANCE"}
    elif remaining & _ITEM - {"NAME"}:
        words.append("an operation or a symbol")
        remaining -= _ITEM | {"_LBRACKET", "CASE", "CHANCE"}
    if "OPERATOR" in remaining:
        words.append("an operator")
        remaining -= {"OPERATOR", "SIGN", "_LBRACKET"}
    words += [_WORDS[kind] for kind in _WORDS if kind in remaining]
    if len(words) < 2:
        return "".join(words) or "something else"
    return f"{', '.join(words[:-1])} or {words[-1]}"


_Advice = tuple[str, str, str]


def _dangling_annotation(error: _Error) -> _Advice | None:
    if error.ended and error.tokens[0].type == "_AT" and "ATTRIBUTE" in error.expected:
        return "dangling-annotation", "expected a definition after the annotation", "put it before an attr or a rule"
    return None


def _no_definition(error: _Error) -> _Advice | None:
    if "ATTRIBUTE" in error.expected and not error.ended:
        return (
            "no-definition",
            "expected a definition",
            "write Rule --> …, function(a) = …, attr name = …, const name = …",
        )
    starts_with_name = error.position == 1 and error.tokens[0].type == "NAME"
    if starts_with_name and "_ARROW" in error.expected and not error.ended:
        return "no-definition", "expected '-->' or '=' after the name of a definition", ""
    return None


def _anonymous_import(error: _Error) -> _Advice | None:
    if error.before == "IMPORT":
        return "anonymous-import", "expected a name for the import", 'write import name : "file.cga"'
    return None


def _single_equals(error: _Error) -> _Advice | None:
    if error.token.type == "_EQUALS" and error.in_condition():
        return "single-equals", "expected '=='", "'==' compares, '=' defines"
    if error.token.value == "==" and "_EQUALS" in error.expected:
        return "double-equals", "expected '='", "'=' defines, '==' compares"
    return None


def _local_value(error: _Error) -> _Advice | None:
    if error.token.type == "_EQUALS" and error.opening() == "" and "NAME" in error.expected:
        hint = "a rule's body has no variables: define a function or an attr outside, or write Rule with (x := 1) -->"
        return "misplaced-equals", "expected an operation or a symbol", hint
    return None


def _else_without_colon(error: _Error) -> _Advice | None:
    if error.before == "_ELSE" and "_COLON" in error.expected:
        return "else-without-colon", "expected ':' after 'else'", "write else : …"
    return None


def _condition_without_colon(error: _Error) -> _Advice | None:
    if "_COLON" in error.expected and error.in_condition():
        return "case-without-colon", "expected an operator or the ':' after the condition", "write case condition : …"
    return None


def _part_without_colon(error: _Error) -> _Advice | None:
    if error.expected >= _SEPARATORS and error.opening() == "_LBRACE":
        hint = "each part is written size : operations, or selector : operations"
        return "part-without-colon", "expected ':' between a part's head and its operations", hint
    return None


def _comma_for_bar(error: _Error) -> _Advice | None:
    if error.token.type == "_COMMA" and error.opening() == "_LBRACE":
        return "comma-for-bar", "expected '|' between two parts", "write { 1 : A | 2 : B }"
    return None


def _bar_for_comma(error: _Error) -> _Advice | None:
    if error.token.type == "_BAR" and error.opening() in ("_LPAR", "_LBRACKET"):
        return (
            "bar-for-comma",
            "expected ',' between two arguments",
            "write f(a, b); '|' separates the parts of a block",
        )
    return None


def _missing_comma(error: _Error) -> _Advice | None:
    starts_operand = error.token.type in _OPERAND | {"NAME"} and not error.ended
    if starts_operand and "_COMMA" in error.expected and error.opening() in ("_LPAR", "_LBRACKET"):
        return "missing-comma", "expected ',', an operator or the closing bracket", ""
    return None


def _percent_missing(error: _Error) -> _Advice | None:
    if error.token.type == "NUMBER" and error.after == "_COLON" and "NAME" in error.expected:
        hint = f"a random branch is written {error.token.value}% : …"
        return "percent-missing", "expected an operation or a symbol", hint
    return None


def _percent_without_colon(error: _Error) -> _Advice | None:
    percent = error.after == "OPERATOR" and error.tokens[error.position + 1].value == "%"
    if error.token.type == "NUMBER" and percent and not error.ended:
        hint = f"write {error.token.value}% : …, with a colon"
        return "percent-without-colon", "expected an operation or a symbol", hint
    return None


def _choice_in_operand(error: _Error) -> _Advice | None:
    name = error.merging()
    if error.token.type in ("CASE", "CHANCE") and not error.ended and name and error.before in ("_LBRACE", "_BAR"):
        hint = "give a rule the choice, and write its name here"
        return "late-choice", f"expected one sequence of operations in each operand of {name.split()[0]}", hint
    return None


def _third_operand(error: _Error) -> _Advice | None:
    name = error.merging().partition(" ")[0]
    if error.token.type != "_BAR" or error.ended or not name or "CLOSE" not in error.expected:
        return None
    if name == "inline":
        return "bad-inline", "expected one sequence of operations in inline", "write inline { A B }"
    hint = f"nest them: {name} {{ {name} {{ A | B }} | C }}"
    return "bad-inline", f"expected '}}' after the second operand of {name}, which has two", hint


def _late_choice(error: _Error) -> _Advice | None:
    """A choice after operations: in CGA a choice must begin a body."""
    if error.token.type in ("CASE", "CHANCE") and not error.ended and error.before not in ("_ARROW", "_COLON"):
        hint = "write them in each branch, or begin another rule with the choice, or put it in brackets: [ case … ]"
        return "late-choice", "operations cannot stand before a choice: expected another operation", hint
    return None


def _foreign_word(error: _Error) -> _Advice | None:
    words = [token for token in error.tokens[: error.position + 1] if token.value in _FOREIGN]
    if words and not error.ended:
        return "foreign-word", f"CGA has no '{words[0].value}': expected {_in_words(error.expected)}", _FOREIGN_HINT
    return None


_FOREIGN = frozenset({"if", "then", "elif", "elseif", "endif", "switch", "return", "for", "while", "def", "function"})
_FOREIGN_HINT = "write case condition : … else : …; repeat with split { … }* or a rule that calls itself"


_USUAL_MISTAKES: tuple[Callable[[_Error], _Advice | None], ...] = (
    _dangling_annotation,
    _anonymous_import,
    _else_without_colon,
    _single_equals,
    _percent_missing,
    _percent_without_colon,
    _choice_in_operand,
    _third_operand,
    _late_choice,
    _foreign_word,
    _no_definition,
    _local_value,
    _comma_for_bar,
    _bar_for_comma,
    _condition_without_colon,
    _part_without_colon,
    _missing_comma,
)
