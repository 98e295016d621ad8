"""Compiler from a grammar to a `Program`: names of random expressions, and the sets of texture coordinates in use."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from weakref import finalize

from grammarlab.derivation.array_expressions import makes_arrays
from grammarlab.derivation.calls.texture_transfer import PIVOT_POSITION
from grammarlab.derivation.expressions import VOCABULARY, CompiledFunction, ExpressionCompiler, Names, number_grammar
from grammarlab.derivation.forest import RuleName, Site, SiteKind
from grammarlab.derivation.functions import CONTEXT_QUERIES
from grammarlab.derivation.functions.shape_attributes import (
    ASK_FOR_PIVOT,
    ASSET_MATERIAL,
    KEY_ATTRIBUTES,
    STATE_DEFAULTS,
)
from grammarlab.derivation.functions.shape_tags import BUILTINS as TAG_FUNCTIONS
from grammarlab.derivation.functions.shape_textures import BUILTINS as TEXTURE_FUNCTIONS
from grammarlab.derivation.functions.street_sides import OLDER_SELECTORS
from grammarlab.derivation.liveness import SHOWN, Liveness
from grammarlab.derivation.operation_sequences import Operations, SequenceCompiler, Successors, override_name
from grammarlab.derivation.operations import OPERATIONS
from grammarlab.derivation.operations.texturing import OPERATIONS as TEXTURING
from grammarlab.derivation.operations.uv_insertion import OPERATIONS as BENDING
from grammarlab.derivation.program import CompiledRule, Program, with_variables
from grammarlab.derivation.state.texture_maps import NUM_SETS
from grammarlab.derivation.state.width_attribute import STREET_WIDTH, StreetWidth
from grammarlab.derivation.state.workspace import Code, CompiledAttribute
from grammarlab.errors import DerivationError, check_type
from grammarlab.language.call_order import groups
from grammarlab.language.grammar import EXAMPLE, Grammar
from grammarlab.language.numbering import RandomPlace, SymbolKey, function_name
from grammarlab.language.syntax.syntax_tree import (
    TRIM_SWITCHES,
    Attribute,
    Binary,
    Block,
    Boolean,
    Call,
    Choice,
    Expression,
    Function,
    Invoke,
    Name,
    Node,
    Number,
    Numbered,
    Rule,
    Scatter,
    Stochastic,
    String,
    Unary,
    Variable,
    alternatives,
    walk,
)
from grammarlab.language.syntax.syntax_tree import Sequence as SyntaxSequence


def mentioned_uv_sets(nodes: Iterable[Node]) -> frozenset[int]:
    """Sets that operations and expressions of a rule file use; all sets if the number of one is computed."""
    mentioned = [_set_of(expression) for node in nodes for expression in _expressions(node)]
    return frozenset().union(*mentioned)


def _expressions(node: Node) -> Iterator[Expression | None]:
    """Argument of a node that names a uv set; None for the first set, which is the default."""
    match node:
        case Invoke() if node.name in TEXTURING or node.name in BENDING:
            yield from node.arguments[: 2 if node.name == "copyUV" else 1]
        case Block(name="split", arguments=(_, _, uv_set)):
            yield uv_set
        case Call() if node.function in TEXTURE_FUNCTIONS:
            yield node.arguments[0] if node.arguments else None
        case Name() if node.identifier in TEXTURE_FUNCTIONS:
            yield None
        case _:
            pass


def _set_of(expression: Expression | None) -> frozenset[int]:
    if expression is None:
        return frozenset({0})
    if isinstance(expression, Number):
        return frozenset(uv_set for uv_set in range(NUM_SETS) if uv_set == expression.value)
    return frozenset(range(NUM_SETS))


_NEED_KEYS = VOCABULARY.draws | KEY_ATTRIBUTES
"""Functions and attributes that depend on the random key of a shape."""
_WORDS: dict[type[Node], str] = {
    Binary: "operator",
    Block: "name",
    Call: "function",
    Invoke: "name",
    Name: "identifier",
    Unary: "operator",
}
"""Field of a node that says what it does."""
_KINDS: dict[str, SiteKind] = {
    "assetApproxRatio": "item",
    "assetApproxSize": "item",
    "assetFitSize": "item",
    "fileRandom": "file",
    "imageApproxRatio": "item",
    "listRandom": "item",
    "p": "bernoulli",
    "rand": "uniform",
}


_PROGRAMS: dict[int, Program] = {}
"""Programs of the grammars that exist, by their `id`: of equal texts, the imported files may differ."""


def compile_grammar(grammar: Grammar) -> Program:
    """A grammar compiled to a program, independent of models and seeds; the same one as long as the grammar exists.

    Raises:
        UsageError: If it is not a grammar.
        DerivationError: If the grammar has no start rule.
    """
    check_type("grammar", grammar, Grammar, EXAMPLE)
    program = _PROGRAMS.get(id(grammar))
    if program is None:
        program = _PROGRAMS[id(grammar)] = _Compilation(grammar).program()
        finalize(grammar, _PROGRAMS.pop, id(grammar), None).atexit = False
    return program


class _Compilation:
    def __init__(self, grammar: Grammar) -> None:
        self._grammar = grammar
        self._numbering = number_grammar(grammar)
        self._nodes = [node for inside in self._numbering.nodes for node in inside]
        self._different = _different(self._nodes)
        self._rules = {key: number for number, key in enumerate(grammar.rules)}
        self._drawing_functions, printing_functions = self._functions_with(_is_random, _prints)
        doing = [node for node in self._nodes if isinstance(node, Call | Name | Scatter | Stochastic)]
        self._drawing_nodes = frozenset(id(node) for node in doing if self._is_drawing(node))
        acting = (node for node in doing if _prints(node) or _called(node) in printing_functions)
        self._acting_nodes = self._drawing_nodes.union(id(node) for node in acting)
        inside = {id(part): nodes for part, nodes in zip(grammar.tree.definitions, self._numbering.nodes, strict=True)}
        self._rule_nodes = {key: inside[id(rule)] for key, rule in grammar.rules.items()}
        self._invoked = {key: frozenset(_invoked(nodes)) for key, nodes in self._rule_nodes.items()}
        self._drawing_rules = self._rules_that_draw()
        self._names = Names(
            frozenset(grammar.attributes),
            {key: CompiledFunction(key[0], key in self._drawing_functions) for key in grammar.functions},
            {random_place.node.number: site for site, random_place in enumerate(self._numbering.random_places)},
            any(map(makes_arrays, self._different)),
        )
        symbols = {name: number for number, name in enumerate(self._numbering.symbols)}
        self._has_trim_planes = _has_trim_planes(self._rule_nodes, self._invoked)
        calls = {key: self._invoked[key] & self._rules.keys() for key in self._rules}
        liveness = Liveness.of(grammar, calls, self._acts, self._has_trim_planes)
        self._successors = Successors(symbols, self._rules, self._draws, liveness, self._renewed, grammar.attributes)
        self._branches = enumerate(self._numbering.branches)

    def program(self) -> Program:
        grammar = self._grammar
        for key, function in grammar.functions.items():
            self._names.functions[key].code = self._value(function.value, function.parameters, function.variables)
        start_rules = {name: number for (name, arity), number in self._rules.items() if arity == 0}
        calls = {
            number: sorted(self._rules[callee] for callee in self._invoked[key] & self._rules.keys())
            for key, number in self._rules.items()
        }
        return Program(
            symbols=self._numbering.symbols,
            rule_names=tuple(
                RuleName(*branch.key, branch.branch, branch.location.line) for branch in self._numbering.branches
            ),
            sites=_describe_sites(grammar, self._numbering.random_places),
            attributes={name: self._attribute(attribute) for name, attribute in grammar.attributes.items()},
            rules=tuple(self._rule(rule) for rule in grammar.rules.values()),
            order=tuple(reversed(groups(calls))),
            start_rules=start_rules,
            default_start=self._default_start(start_rules),
            state_names=self._state_names(),
            most_successors=max((len(branch.successors) for branch in self._numbering.branches), default=0),
            uv_sets=mentioned_uv_sets(self._nodes),
            has_trim_planes=self._has_trim_planes,
            trims_again=_trims_again(self._nodes),
            selects_streets=any(map(_selects_streets, self._different)),
            uses_tags=any(map(_reads_tags, self._different)),
            import_prefixes=tuple(f"{alias}." for alias in grammar.imports),
            # Last: the functions that are called are known when everything is compiled.
            reads_tree_keys="getTreeKey" in self._names.called,
            queries_context=not self._names.called.isdisjoint(CONTEXT_QUERIES),
        )

    def _attribute(self, attribute: Attribute) -> CompiledAttribute:
        return CompiledAttribute(
            attribute.name,
            self._value(attribute.value, (), attribute.variables),
            draws=self._draws_itself(attribute.value, *attribute.variables),
            street_width=_street_width(attribute),
            location=attribute.location,
        )

    def _value(self, choice: Choice, parameters: tuple[str, ...], variables: Sequence[Variable]) -> Code:
        """Code of the value of a definition, with its local variables evaluated first, in order."""
        codes, names = self._variables(parameters, variables)
        code = ExpressionCompiler(self._names, names).choice(choice)
        return (
            code if not codes else lambda shapes, workspace: code(with_variables(shapes, codes, workspace), workspace)
        )

    def _variables(
        self, parameters: tuple[str, ...], variables: Sequence[Variable]
    ) -> tuple[tuple[Code, ...], tuple[str, ...]]:
        """Code of each local variable of a definition, and the names of its parameters and variables."""
        names, codes = parameters, []
        for variable in variables:
            codes.append(ExpressionCompiler(self._names, names).expression(variable.value))
            names = (*names, variable.name)
        return tuple(codes), names

    def _rule(self, rule: Rule) -> CompiledRule:
        variables, names = self._variables(rule.parameters, rule.variables)
        expressions = ExpressionCompiler(self._names, names)

        def leaf(choice: Choice, path: tuple[int, ...]) -> Operations:
            if not isinstance(choice, SyntaxSequence):
                raise DerivationError("expected operations, found an expression", choice.location)
            number, branch = next(self._branches)
            return SequenceCompiler(expressions, self._successors, branch).sequence(choice, rule=number)

        body = expressions.branching(rule.body, leaf)
        is_bare = not self._successors.liveness.rules[rule.name, len(rule.parameters)] & SHOWN
        return CompiledRule(self._successors.symbols[rule.name], body, variables, is_bare)

    def _default_start(self, start_rules: Mapping[str, int]) -> str:
        rules = (*self._grammar.start_rules, *self._grammar.rules.values())
        marked = [rule.name for rule in rules if rule.name in start_rules]
        if not marked:
            raise DerivationError(
                "the grammar has no start rule", None, "mark a rule without parameters with @StartRule"
            )
        return marked[0]

    def _draws(self, node: Node) -> bool:
        """Whether a part of the tree, or anything derived from it, may draw random numbers."""
        nodes = list(walk(node))
        return self._draw_themselves(nodes) or not self._drawing_rules.isdisjoint(_invoked(nodes))

    def _draws_itself(self, *nodes: Node) -> bool:
        return self._draw_themselves(inner for node in nodes for inner in walk(node))

    def _draw_themselves(self, nodes: Iterable[Node]) -> bool:
        return not self._drawing_nodes.isdisjoint(map(id, nodes))

    def _is_drawing(self, node: Node) -> bool:
        return _is_random(node) or isinstance(node, Scatter) or _called(node) in self._drawing_functions

    def _acts(self, node: Node) -> bool:
        """Whether evaluating a part of the tree may draw or print."""
        return not self._acting_nodes.isdisjoint(map(id, walk(node)))

    def _functions_with(self, *properties: Callable[[Node], bool]) -> tuple[frozenset[SymbolKey], ...]:
        """Functions with a node of each property in their values, or in those of functions that they call."""
        inside = {
            key: [node for part in (function.value, *function.variables) for node in walk(part)]
            for key, function in self._grammar.functions.items()
        }
        calls = {key: {_called(node) for node in nodes} - {None} for key, nodes in inside.items()}
        return tuple(
            _spread({key for key, nodes in inside.items() if any(map(has, nodes))}, calls) for has in properties
        )

    def _rules_that_draw(self) -> frozenset[SymbolKey]:
        drawing = {key for key, nodes in self._rule_nodes.items() if self._draw_themselves(nodes)}
        return _spread(drawing, self._invoked)

    def _renewed(self, item: Invoke) -> tuple[str, ...]:
        """Attributes of an imported file that depend on those that a call redefines, each after those it reads."""
        redefined = frozenset(_redefined(item))
        prefix = f"{item.name.rpartition('.')[0]}."
        if redefined.isdisjoint(self._grammar.attributes):
            return ()
        changed = _spread(set(redefined & self._references.keys()), self._references) - redefined
        return tuple(key for key in self._order if isinstance(key, str) and key in changed and key.startswith(prefix))

    @cached_property
    def _references(self) -> dict[str | SymbolKey, list[str | SymbolKey]]:
        """What the values of attributes, by name, and of functions, by symbol, may read of both."""
        definitions = {**self._grammar.attributes, **self._grammar.functions}
        return {key: [name for name in _named(value) if name in definitions] for key, value in definitions.items()}

    @cached_property
    def _order(self) -> tuple[str | SymbolKey, ...]:
        """Attributes and functions, each after those that it reads."""
        return tuple(key for group in groups(self._references) for key in group)

    def _state_names(self) -> frozenset[str]:
        read = {node.identifier for node in self._different if isinstance(node, Name)}
        invoked = [node for node in self._nodes if isinstance(node, Invoke)]
        changed = {
            node.arguments[0].identifier
            for node in invoked
            if node.name == "set" and node.arguments and isinstance(node.arguments[0], Name)
        }
        changed |= {name for node in invoked if node.overrides for name in (*_redefined(node), *self._renewed(node))}
        asks = (
            not read.isdisjoint(ASK_FOR_PIVOT)
            or any(isinstance(node, Call) and node.function == "convert" for node in self._different)
            or any(node.name == "translate" for node in invoked)
        )
        names = (read & STATE_DEFAULTS.keys()) | (changed & self._grammar.attributes.keys())
        names |= set(PIVOT_POSITION) if asks else set()
        return frozenset(names | ({ASSET_MATERIAL} if any(map(_asks_for_asset_material, self._different)) else set()))


def _different(nodes: Iterable[Node]) -> tuple[Node, ...]:
    """One node of each type and word: a tenth of all nodes of a long rule file."""
    different: dict[tuple[type[Node], str], Node] = {}
    for node in nodes:
        kind = type(node)
        field = _WORDS.get(kind)
        different.setdefault((kind, getattr(node, field) if field else ""), node)
    return tuple(different.values())


def _redefined(item: Invoke) -> Iterator[str]:
    """Full names of the attributes that a call redefines."""
    return (override_name(item, each) for each in item.overrides or () if isinstance(each, Attribute))


def _invoked(nodes: Iterable[Node]) -> Iterator[SymbolKey]:
    """Symbols of the shapes that nodes make."""
    for node in nodes:
        if isinstance(node, Invoke) and node.name not in OPERATIONS:
            yield node.name, len(node.arguments)


def _describe_sites(grammar: Grammar, random_places: Sequence[RandomPlace]) -> tuple[Site, ...]:
    """Sites of a forest, with names as described by `Site.name`.

    Args:
        grammar: the grammar.
        random_places: random places of the grammar.
    """
    names = _values_of_attributes(grammar, random_places)
    per_definition = Counter(
        random_place.owner for random_place in random_places if random_place.node.number not in names
    )
    attribute_names = {*names.values(), *grammar.attributes}
    numbers: Counter[str] = Counter()
    sites: list[Site] = []
    for random_place in random_places:
        node, owner = random_place.node, random_place.owner
        name = names.get(node.number)
        if name is None:
            numbers[owner] += 1
            plain = per_definition[owner] == 1 and owner not in attribute_names
            name = owner if plain else f"{owner}#{numbers[owner]}"
        choices = len(node.branches) if isinstance(node, Stochastic) else 0
        kind = "choice" if isinstance(node, Stochastic) else _KINDS[function_name(node)]
        sites.append(Site(name, kind, owner, node.location.line, choices))
    return tuple(sites)


def _values_of_attributes(grammar: Grammar, random_places: Sequence[RandomPlace]) -> dict[int, str]:
    """Names of attributes, by the number of the random expression whose draw is the attribute's value."""
    by_owner: dict[str, list[RandomPlace]] = {}
    for random_place in random_places:
        by_owner.setdefault(random_place.owner, []).append(random_place)
    names: dict[int, str] = {}
    for name, attribute in grammar.attributes.items():
        inside = [random_place.node for random_place in by_owner.get(name, ()) if random_place.definition is attribute]
        uniform = {node.number for node in inside if function_name(node) == "rand"}
        leaves = [leaf.number if isinstance(leaf, Numbered) else -1 for leaf in alternatives(attribute.value)]
        if uniform.issuperset(leaves):
            names |= dict.fromkeys(leaves, name)
        elif inside and inside[0] is attribute.value and (len(inside) == 1 or isinstance(attribute.value, Call)):
            names[inside[0].number] = name
    return names


def _street_width(attribute: Attribute) -> StreetWidth:
    if attribute.name != STREET_WIDTH or attribute.constant:
        return "none"
    leaves = list(alternatives(attribute.value))
    if any(isinstance(leaf, Boolean | String) for leaf in leaves):
        return "none"
    return "edges" if all(map(makes_arrays, leaves)) else "widest"


def _selects_streets(node: Node) -> bool:
    if isinstance(node, Invoke):
        return node.name == "envelope"
    return isinstance(node, Name) and (node.identifier.startswith("street.") or node.identifier in OLDER_SELECTORS)


def _asks_for_asset_material(node: Node) -> bool:
    if isinstance(node, Invoke):
        return node.name == "resetMaterial"
    return isinstance(node, Call) and node.function == "getMaterial"


def _reads_tags(node: Node) -> bool:
    name = node.function if isinstance(node, Call) else node.identifier if isinstance(node, Name) else ""
    return name in TAG_FUNCTIONS


def _has_trim_planes(
    rules: Mapping[SymbolKey, Sequence[Node]], calls: Mapping[SymbolKey, frozenset[SymbolKey]]
) -> bool:
    """Whether rules insert or trim meshes below components, by which trim planes may show.

    Args:
        rules: the nodes of each rule.
        calls: the symbols that each rule calls directly.
    """
    trimming = _spread({key for key, nodes in rules.items() if any(map(_trims, nodes))}, calls)
    blocks = (node for nodes in rules.values() for node in nodes if isinstance(node, Block) and node.name == "comp")
    inside = [node for block in blocks for node in walk(block.group)]
    return any(map(_trims, inside)) or not trimming.isdisjoint(_invoked(inside))


def _trims_again(nodes: Iterable[Node]) -> bool:
    """Whether rules may switch trim planes on; if not, shapes need none while they are off."""
    changes = [node.arguments for node in nodes if isinstance(node, Invoke) and node.name == "set"]
    return any(len(change) == 2 and _may_be_switch(change[0]) and change[1] != Boolean(False) for change in changes)


def _may_be_switch(target: Expression) -> bool:
    """Whether ``set`` says whether planes apply; a target that is not a name may be any attribute."""
    return not isinstance(target, Name) or target.identifier in TRIM_SWITCHES


def _trims(node: Node) -> bool:
    return isinstance(node, Invoke) and (node.name in ("i", "trim") or node.name.startswith("primitive"))


def _is_random(node: Node) -> bool:
    """Whether a node needs the random key of its shape."""
    return isinstance(node, Stochastic) or function_name(node) in _NEED_KEYS


def _prints(node: Node) -> bool:
    return isinstance(node, Call) and node.function == "print"


def _called(node: Node) -> SymbolKey | None:
    """Function of the grammar that a node calls, if it exists."""
    if isinstance(node, Call):
        return node.function, len(node.arguments)
    return (node.identifier, 0) if isinstance(node, Name) else None


def _named(definition: Attribute | Function) -> Iterator[str | SymbolKey]:
    """Attributes, by name, and functions, by symbol, that the value of a definition may read."""
    for part in (definition.value, *definition.variables):
        for called in filter(None, map(_called, walk(part))):
            yield from (called[0], called)


def _spread(drawing: set, calls: Mapping) -> frozenset:
    """All definitions that call one of ``drawing``, directly or not."""
    callers: dict = {}
    for caller, callees in calls.items():
        for callee in callees:
            callers.setdefault(callee, set()).add(caller)
    reached, open_ends = set(drawing), list(drawing)
    while open_ends:
        new = callers.get(open_ends.pop(), set()) - reached
        reached |= new
        open_ends += new
    return frozenset(reached)
