"""Presets of rule files: a style, a start rule and values of attributes, chosen by users and written into the text.

So the designs, hashes, labels and learned files of a preset are those of an ordinary rule file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from grammarlab.errors import UsageError, check_type
from grammarlab.language.grammar import Grammar, default_style, is_start_rule
from grammarlab.language.syntax.outline import outline
from grammarlab.language.syntax.printing import expression, value
from grammarlab.language.syntax.syntax_tree import Attribute, Boolean, Number, Rule, String
from grammarlab.language.syntax.tokens import Token, tokenize

_START = "@StartRule\n"


@dataclass(frozen=True, slots=True)
class RuleChoices:
    """What a user chooses for a rule file whose text does not say it, or says something else.

    >>> import grammarlab as gl
    >>> gl.load("toy", gl.RuleChoices(attributes={"h1": 2})).attributes["h1"].value.value
    2.0
    """

    library: Path | str | None = None
    """Folder of further projects, such as ``ESRI.lib``, to import from; kept as a path."""
    style: str = ""
    """Style, instead of the default style."""
    start_rule: str = ""
    """Start rule, instead of the marked ones."""
    attributes: Mapping[str, float | bool | str] = field(default_factory=dict, hash=False)
    """Values of attributes, instead of those of the file; kept in the order of their names, numbers as floats."""

    def __post_init__(self) -> None:
        """Check and normalize the values.

        Raises:
            UsageError: If a value has another type, or a number is too large.
        """
        check_type("start_rule", self.start_rule, str, '"Lot"')
        check_type("style", self.style, str, '"Tall"')
        check_type("attributes", self.attributes, Mapping, '{"height": 12}')
        if self.library is not None:
            check_type("library", self.library, (Path, str), '"../ESRI.lib"')
            object.__setattr__(self, "library", Path(self.library))
        object.__setattr__(self, "attributes", _plain_values(self.attributes) if self.attributes else {})

    @property
    def changes_text(self) -> bool:
        """Whether there is a style, a start rule or a value of an attribute."""
        return bool(self.style or self.start_rule or self.attributes)

    def apply(self, grammar: Grammar) -> Grammar:
        """A rule file in the style, with the start rule and the values; the library is for reading it.

        Raises:
            LanguageError: If it has no such style.
            UsageError: If it has no such start rule or attribute, or a value has another type than its attribute.
        """
        if self.style:
            from grammarlab.language.styles import styled  # noqa: PLC0415  # few runs use a style

            grammar = styled(grammar, self.style)
        return preset(grammar, self.start_rule, self.attributes)


NO_CHOICES = RuleChoices()
"""A rule file as it is."""


def _plain_values(attributes: Mapping[str, float | bool | str]) -> dict[str, float | bool | str]:
    from grammarlab.language.attribute_values import plain_value  # noqa: PLC0415  # see `preset`

    for name in attributes:
        check_type("name of an attribute", name, str, '"height"')
    return {name: plain_value(name, attributes[name]) for name in sorted(attributes)}


def preset(
    grammar: Grammar, start_rule: str = "", attributes: Mapping[str, float | bool | str] | None = None
) -> Grammar:
    """A rule file with one start rule, and with constants as values of attributes.

    The chosen rule alone is marked ``@StartRule``, unless it is the start rule without a mark. Attributes keep their
    annotations; conditions and random choices of their values are replaced. Everything else keeps its text. Draws are
    numbered through the text (`grammarlab.language.syntax.syntax_tree.number`), so a value that replaces a function, a
    name or a choice changes the draws behind it, though not their density.

    Args:
        grammar: a rule file.
        start_rule: name of a rule without parameters; empty for the start rules of the file.
        attributes: values by name.

    Raises:
        UsageError: If it has no such rule or attribute, or a value has another type than its attribute.

    >>> grammar = Grammar.parse("attr h = rand(3)  @StartRule Lot --> A  House --> extrude(h)")
    >>> preset(grammar, "House", {"h": 12.0}).text.split()
    ['attr', 'h', '=', '12', 'Lot', '-->', 'A', '@StartRule', 'House', '-->', 'extrude(h)']
    """
    # Most runs choose nothing, and checks of values load NumPy.
    from grammarlab.language.attribute_values import checked_attributes  # noqa: PLC0415
    from grammarlab.language.rewriting import edited  # noqa: PLC0415

    values = checked_attributes(attributes or {}, grammar)
    edits = [*(_start_edits(grammar, start_rule) if start_rule else ()), *_value_edits(grammar, values)]
    text = edited(grammar.text, edits)
    if text == grammar.text:
        return grammar
    return replace(
        Grammar.parse(text, grammar.file),
        libraries=grammar.libraries,
        import_findings=grammar.import_findings,
        assets=grammar.assets,
    )


def preset_differences(before: Grammar, now: Grammar) -> tuple[str, ...]:
    """Differences between the start rules, and between the values of attributes, of two rule files, abbreviated.

    >>> before = Grammar.parse("attr h = 3  Lot --> A  B --> A")
    >>> preset_differences(before, Grammar.parse("attr h = rand(3)  Lot --> A  @StartRule B --> A"))
    ('start rule Lot, now B', 'attribute h = 3, now rand(3)')
    """
    from grammarlab.language.attribute_values import excerpt  # noqa: PLC0415  # see `preset`

    starts = [", ".join(rule.name for rule in grammar.start_rules) for grammar in (before, now)]
    pairs = [("start rule ", *starts)]
    for name, attribute in before.attributes.items():
        if name in now.attributes:
            values = (value(node.value) for node in (attribute, now.attributes[name]))
            pairs.append((f"attribute {excerpt(name)} = ", *values))
    return tuple(f"{what}{excerpt(old)}, now {excerpt(new)}" for what, old, new in pairs if old != new)


def _start_edits(grammar: Grammar, name: str) -> Iterator[tuple[int, int, str]]:
    """Edits that mark one rule as the start rule, and no other."""
    start_rule = grammar.rules.get((name, 0))
    if start_rule is None:
        from grammarlab.language.attribute_values import nearest_names  # noqa: PLC0415  # see `preset`

        names = [rule.name for rule in grammar.rules.values() if not rule.parameters]
        has_parameters = any(rule.name == name for rule in grammar.rules.values())
        problem = "has parameters; expected a rule without" if has_parameters else "is not a rule of the file"
        raise UsageError(f"start rule {name!r:.80} {problem}; {nearest_names(name, names)}")
    if all(rule is start_rule for rule in grammar.start_rules):
        return
    for node, (start, end) in zip(default_style(grammar.tree), grammar.tree.spans, strict=False):
        if not isinstance(node, Rule) or is_start_rule(node) == (node is start_rule):
            continue
        if node is start_rule:
            yield start, start, _START
        else:
            for first, last in _start_marks(_tokens(grammar.text[start:end])):
                stop = start + last
                stop += len(grammar.text[stop:end]) - len(grammar.text[stop:end].lstrip())
                yield start + first, stop, ""


def _start_marks(tokens: Sequence[Token]) -> Iterator[tuple[int, int]]:
    """Offsets of the beginning and end of each mark of a start rule: an annotation or the keyword."""
    position = 0
    while tokens[position].type == "_AT":
        end = _annotation_end(tokens, position)
        if tokens[position + 1].value.lower() == "startrule":
            yield tokens[position].start, tokens[end - 1].end
        position = end
    if tokens[position].value == "start" and tokens[position + 1].type == "NAME":
        yield tokens[position].start, tokens[position].end


def _value_edits(grammar: Grammar, values: Mapping[str, float | bool | str]) -> Iterator[tuple[int, int, str]]:
    """Edits that replace the values of attributes, local variables included."""
    for node, (start, end) in zip(default_style(grammar.tree), grammar.tree.spans, strict=False):
        if isinstance(node, Attribute) and node.name in values and node is grammar.attributes[node.name]:
            tokens, position = _tokens(grammar.text[start:end]), 0
            while tokens[position].type == "_AT":
                position = _annotation_end(tokens, position)
            yield start + tokens[position + 1].end, end, f" = {_literal(values[node.name])}"


def _annotation_end(tokens: Sequence[Token], position: int) -> int:
    """Index past the tokens of the annotation that begins at an index."""
    position += 2
    depth = 0
    while depth or tokens[position].type == "_LPAR":
        depth += (tokens[position].type == "_LPAR") - (tokens[position].type == "RPAR")
        position += 1
    return position


def _tokens(text: str) -> list[Token]:
    """Tokens of the text of a definition."""
    return [token for chunk in outline(tokenize(text)).chunks for token in chunk.tokens]


def _literal(plain: float | bool | str) -> str:
    if isinstance(plain, bool):
        return expression(Boolean(plain))
    return expression(String(plain) if isinstance(plain, str) else Number(plain))
