"""Canonical style of rule files.

A definition is on one line if it fits and has no comment inside; otherwise every branch and every part
gets its own line, and operations fill lines. Comments go before the next operation, part, branch, end of a group or
definition, or to the end of the line if they were at the end of a line. Formatting is idempotent.
"""

from __future__ import annotations

from collections import deque

from grammarlab.errors import Location
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax import printing
from grammarlab.language.syntax.syntax_tree import (
    Annotation,
    Attribute,
    Block,
    Case,
    Choice,
    Definition,
    Function,
    Group,
    Import,
    Inline,
    Invoke,
    Item,
    Node,
    Part,
    Rule,
    RuleFile,
    Scatter,
    Scoped,
    Sequence,
    Stochastic,
)
from grammarlab.language.syntax.tokens import Comment, Token, tokenize

WIDTH = 100
"""Largest length of a line that can be broken, in characters."""
_STEP = "    "


def format_grammar(grammar: Grammar | RuleFile) -> str:
    """A rule file in the canonical style.

    Args:
        grammar: a grammar, whose comments are kept, or a bare tree.

    Raises:
        ValueError: If a number of a bare tree is infinite or NaN, which CGA cannot express.
    """
    if isinstance(grammar, RuleFile):
        return _Formatter(grammar, "").run()
    return _Formatter(grammar.tree, grammar.text).run()


class _Formatter:
    """Writes one rule file, line by line."""

    def __init__(self, tree: RuleFile, text: str) -> None:
        words = tokenize(text)
        self.tree = tree
        self.source = text.splitlines()
        self.comments = deque(words.comments)
        self.version = _version_location(words.tokens)
        self.brackets = _Brackets(words.tokens)
        self.lines: list[str] = []
        self.sealed = -1
        """Index of the last line that a comment was added to."""

    def run(self) -> str:
        if self.tree.version:
            if self.version is not None:
                self._leading(self.version, 0)
            self.lines.append(f'version "{self.tree.version}"')
        previous: Definition | None = None
        for definition in self.tree.definitions:
            anchor = _first_location(definition)
            self._trailing(anchor)
            gap = len(self.lines)
            first = self.comments[0].location if self._has_comment(anchor) else anchor
            self._leading(anchor, gap)
            start = len(self.lines)
            self._definition(definition)
            tall = len(self.lines) - start > 1
            if gap and (self._blank_before(first) or previous is None or tall or _kind(previous) != _kind(definition)):
                self._open_gap(gap)
            previous = definition if not tall else None
        self._trailing(None)
        self._leading(None, 0)
        return "".join(f"{line.rstrip()}\n" for line in self.lines)

    # Comments

    def _has_comment(self, before: Location | None) -> bool:
        return bool(self.comments) and (before is None or self.comments[0].location < _start(before))

    def _trailing(self, before: Location | None) -> None:
        """Add the comment from the end of the line just written, if any."""
        if self._has_comment(before) and not self.comments[0].alone and self.lines:
            self._append(self.comments.popleft())

    def _append(self, comment: Comment) -> None:
        if self.sealed == len(self.lines) - 1:
            self._write_comment(comment, "")
        else:
            self.lines[-1] += f"  {comment.text.rstrip()}"
            self.sealed = len(self.lines) - 1

    def _write_comment(self, comment: Comment, indent: str) -> None:
        self.lines.append(indent + comment.text.rstrip())
        self.sealed = len(self.lines) - 1

    def _leading(self, before: Location | None, start: int) -> None:
        """Write the comments before a definition, with the empty lines around them."""
        while self._has_comment(before):
            comment = self.comments.popleft()
            if len(self.lines) > start and self._blank_before(comment.location):
                self.lines.append("")
            self._write_comment(comment, "")
        if before is not None and len(self.lines) > start and self._blank_before(before):
            self.lines.append("")

    def _inner(self, before: Location, indent: str) -> bool:
        """Write the comments before a place inside a definition; returns whether there were any."""
        has_comment = self._has_comment(before)
        while self._has_comment(before):
            comment = self.comments.popleft()
            if comment.alone or not self.lines or self.sealed == len(self.lines) - 1:
                self._write_comment(comment, indent)
            else:
                self._append(comment)
        return has_comment

    def _commented(self, node: Node) -> bool:
        """Whether a comment is before the last place for comments inside a node."""
        if not self.comments:
            return False
        return any(self._has_comment(location) for location in self._anchors(node))

    def _anchors(self, node: Node) -> list[Location]:
        """Places for comments inside a node."""
        locations: list[Location] = []
        stack: list[Node] = [node]
        while stack:
            inner = stack.pop()
            stack += _parts_on_lines(inner)
            if isinstance(inner, Case | Stochastic):
                locations += [self._branch_start(inner, index) for index in range(len(inner.branches))]
            elif isinstance(inner, Invoke | Block | Scoped | Scatter | Inline | Part):
                locations.append(self.brackets.start(inner))
            if isinstance(inner, Block | Scoped | Scatter | Inline):
                locations += [self.brackets.end(opening) for opening in self.brackets.of_item(inner)]
        return locations

    def _branch_start(self, choice: Case | Stochastic, index: int) -> Location:
        """Place of a condition or percentage, or of what follows ``else :``."""
        head = choice.conditions[index] if isinstance(choice, Case) else choice.percentages[index]
        return self.brackets.start(choice.branches[index] if head is None else head)

    def _blank_before(self, location: Location) -> bool:
        return 1 < location.line <= len(self.source) and not self.source[location.line - 2].strip()

    def _open_gap(self, index: int) -> None:
        self.lines.insert(index, "")
        self.sealed += self.sealed >= index

    # Definitions

    def _definition(self, definition: Definition) -> None:
        self._annotations(definition.annotations)
        self._inner(definition.location, "")
        match definition:
            case Rule():
                keyword = f"{definition.keyword} " if definition.keyword else ""
                self._headed(f"{keyword}{printing.signature(definition)} -->", definition.body, rule=True)
            case Attribute():
                keyword = "const" if definition.constant else "attr"
                self._headed(f"{keyword} {printing.signature(definition)} =", definition.value, rule=False)
            case Function():
                keyword = "const " if definition.constant else ""
                self._headed(f"{keyword}{printing.signature(definition)} =", definition.value, rule=False)
            case Import():
                self.lines.append(printing.import_statement(definition))
            case _:
                self.lines.append(printing.style_statement(definition))

    def _annotations(self, annotations: tuple[Annotation, ...]) -> None:
        line = ""
        for annotation in annotations:
            text = printing.annotation(annotation)
            if line and (self._has_comment(annotation.location) or len(line) + len(text) >= WIDTH):
                self.lines.append(line)
                line = ""
            self._inner(annotation.location, "")
            line = f"{line} {text}".lstrip()
        if line:
            self.lines.append(line)

    def _headed(self, head: str, choice: Choice, rule: bool) -> None:
        """Write a definition on one line, or its head and then its body on further lines."""
        branches = isinstance(choice, Case | Stochastic)
        flat = f"{head} {printing.body(choice) if rule else printing.value(choice)}".rstrip()
        if not self._commented(choice) and not (branches and rule) and (len(flat) <= WIDTH or not (rule or branches)):
            self.lines.append(flat)
            return
        self.lines.append(head)
        self._choice(choice, _STEP, rule)

    # Choices

    def _choice(self, choice: Choice, indent: str, rule: bool) -> None:
        if isinstance(choice, Sequence):
            self._sequence(choice, indent)
        elif not isinstance(choice, Case | Stochastic):
            self._inner(choice.location, indent)
            self.lines.append(indent + printing.value(choice))
        else:
            for index in range(len(choice.branches)):
                self._branch(choice, index, indent, rule)

    def _branch(self, choice: Case | Stochastic, index: int, indent: str, rule: bool) -> None:
        branch = choice.branches[index]
        self._inner(self._branch_start(choice, index), indent)
        head = indent + printing.branch_head(choice, index)
        follows = index + 1 < len(choice.branches)
        opening, closing = "", ""
        if rule:
            opening, branch, closing = printing.guarded(choice, index, branch)
        elif follows and printing.open_marks(branch):
            opening, closing = "(", ")"
        text = printing.body(branch) if rule else printing.value(branch)
        flat = f"{head} {opening}{text}{closing}".rstrip()
        nested = isinstance(branch, Case | Stochastic)
        if not self._commented(branch) and len(flat) <= WIDTH and not (nested and rule):
            self.lines.append(flat)
            return
        self.lines.append(f"{head} {opening}".rstrip())
        self._choice(branch, indent + _STEP, rule)
        if closing:
            self.lines.append(indent + _STEP + closing.strip())

    # Operations

    def _sequence(self, sequence: Sequence, indent: str) -> None:
        line = ""
        for item in sequence.items:
            start = self.brackets.start(item)
            if line and self._has_comment(start):
                self.lines.append(line)
                line = ""
            self._inner(start, indent)
            flat = printing.item(item)
            broken = not isinstance(item, Invoke) and (self._commented(item) or len(indent) + len(flat) > WIDTH)
            # Braces that one operation does not need keep the comments inside of them.
            braced = _needs_braces(item) or self._has_comment_before_end(item)
            head = _head(item, braced) if broken else flat
            if line and len(line) + 1 + len(head) > WIDTH:
                self.lines.append(line)
                line = ""
            line = f"{line} {head}" if line else indent + head
            if broken:
                self.lines.append(line)
                line = self._broken(item, indent, braced)
        if line:
            self.lines.append(line)

    def _broken(self, item: Item, indent: str, braced: bool) -> str:
        """Write the content of an item on separate lines; returns its last line, which may continue, or nothing."""
        openings = self.brackets.of_item(item)
        opening = openings[0] if openings else None
        match item:
            case Block():
                last = self._group(item.group, indent, opening)
                if item.remainder is None:
                    return last
                self.lines.append(f"{last} {{")
                return self._group(item.remainder, indent, openings[1] if len(openings) > 1 else None)
            case Scoped() | Scatter() | Inline():
                self._choice(item.body, indent + _STEP, rule=True)
                if isinstance(item, Inline) and item.second is not None:
                    for bar in self.brackets.bars(opening)[:1]:
                        self._inner(bar, indent + _STEP)
                    self.lines.append(f"{indent}|")
                    self._choice(item.second, indent + _STEP, rule=True)
                self._before_end(opening, indent + _STEP)
                if braced:
                    return indent + ("]" if isinstance(item, Scoped) else "}")
        return ""

    def _group(self, group: Group, indent: str, opening: int | None) -> str:
        for index, member in enumerate(group.parts):
            inner = self.brackets.of_member(opening, index) if isinstance(member, Group) else None
            self._inner(member.location if inner is None else self.brackets.place(inner), indent + _STEP)
            lead = indent + ("  | " if index else _STEP)
            flat = lead + printing.member(member)
            ends = inner is not None and self._has_comment(self.brackets.end(inner))
            if not ends and not self._commented(member) and len(flat) <= WIDTH:
                self.lines.append(flat)
            elif isinstance(member, Group):
                self.lines.append(lead + "{")
                self.lines.append(self._group(member, indent + _STEP, inner))
            else:
                self.lines.append(lead + printing.part_head(member))
                self._choice(member.body, indent + _STEP + _STEP, rule=True)
        self._before_end(opening, indent + _STEP)
        return indent + ("}*" if group.repeated else "}")

    def _has_comment_before_end(self, item: Item) -> bool:
        """Whether a comment is before the closing bracket of an item."""
        return any(self._has_comment(self.brackets.end(opening)) for opening in self.brackets.of_item(item)[:1])

    def _before_end(self, opening: int | None, indent: str) -> None:
        """Write the comments before a closing bracket."""
        if opening is not None:
            self._inner(self.brackets.end(opening), indent)


class _Brackets:
    """Brackets of a rule file, by the numbers of their opening tokens; none in a file without text."""

    def __init__(self, tokens: tuple[Token, ...]) -> None:
        self._tokens = tokens
        self._number = {(token.location.line, token.location.column): number for number, token in enumerate(tokens)}
        self._closing: dict[int, int] = {}
        self._bars: dict[int, list[int]] = {}
        self._around: list[int] = []
        """Number of the innermost bracket around each token, or of the bracket that it closes; -1 without one."""
        opened: list[int] = []
        for number, token in enumerate(tokens):
            self._around.append(opened[-1] if opened else -1)
            if token.type in _OPENING:
                opened.append(number)
                self._bars[number] = []
            elif token.type in _CLOSING and opened:
                self._closing[opened.pop()] = number
            elif token.type == "_BAR" and opened:
                self._bars[opened[-1]].append(number)

    def place(self, opening: int) -> Location:
        """Place of the opening bracket."""
        return self._tokens[opening].location

    def end(self, opening: int) -> Location:
        """Place of the closing bracket."""
        return self._tokens[self._closing[opening]].location

    def start(self, node: Node) -> Location:
        """Place of the first token of an operation, of operations, or of another node."""
        if isinstance(node, Sequence) and node.items:
            return self.start(node.items[0])
        if isinstance(node, Scoped):
            return next(map(self.place, self.of_item(node)), node.location)
        return node.location

    def bars(self, opening: int | None) -> list[Location]:
        """Places of the bars that divide what a bracket contains."""
        return [] if opening is None else [self._tokens[number].location for number in self._bars[opening]]

    def of_item(self, item: Item) -> list[int]:
        """The brackets of an item in the order of the text: two for a block with a remainder, else at most one."""
        number = self._number.get((item.location.line, item.location.column))
        if number is None:
            return []
        if isinstance(item, Scoped):
            # A scope is at the place of its first operation.
            around = self._around[number]
            for _ in range(_scopes_at_start(item.body)):
                around = self._around[around]
            return [around] if around in self._closing else []
        brackets: list[int] = []
        number += 1
        while number in self._closing and self._tokens[number].type != "_LBRACKET":
            if self._tokens[number].type == "_LBRACE":
                brackets.append(number)
            number = self._closing[number] + 1
            if number < len(self._tokens) and self._tokens[number].value == "*":
                number += 1
        count = 2 if isinstance(item, Block) and item.remainder is not None else 1
        return brackets[:count] if isinstance(item, Block | Scatter | Inline) else []

    def of_member(self, opening: int | None, index: int) -> int | None:
        """The bracket of a group that is a member of a group."""
        if opening is None:
            return None
        start = ([opening, *self._bars[opening]])[index] + 1
        return start if start in self._closing else None


_OPENING = frozenset(["_LPAR", "_LBRACE", "_LBRACKET"])
_CLOSING = frozenset(["RPAR", "CLOSE", "RBRACKET"])


def _scopes_at_start(body: Choice) -> int:
    """Number of scopes in brackets that begin where a body begins."""
    count = 0
    while isinstance(body, Sequence) and body.items and isinstance(body.items[0], Scoped):
        body, count = body.items[0].body, count + 1
    return count


def _parts_on_lines(node: Node) -> tuple[Node, ...]:
    """Nodes directly below a node that can have lines of their own; none in an expression."""
    match node:
        case Case() | Stochastic():
            return node.branches
        case Sequence():
            return node.items
        case Group():
            return node.parts
        case Block():
            return (node.group,) if node.remainder is None else (node.group, node.remainder)
        case Inline():
            return (node.body,) if node.second is None else (node.body, node.second)
        case Scoped() | Scatter() | Part():
            return (node.body,)
    return ()


def _head(item: Item, braced: bool) -> str:
    """First line of an item that spans several lines."""
    match item:
        case Scoped():
            return "["
        case Block() | Scatter() | Inline():
            return f"{printing.item_head(item)} {{" if braced else printing.item_head(item)
    return printing.item(item)


def _needs_braces(item: Item) -> bool:
    return not isinstance(item, Inline) or printing.needs_braces(item)


def _first_location(definition: Definition) -> Location:
    return definition.annotations[0].location if definition.annotations else definition.location


def _start(location: Location) -> Location:
    return Location(location.line, location.column, 0, "")


def _version_location(tokens: tuple[Token, ...]) -> Location | None:
    return tokens[0].location if tokens and tokens[0].value == "version" else None


def _kind(definition: Definition) -> type:
    return Attribute if isinstance(definition, Function) else type(definition)
