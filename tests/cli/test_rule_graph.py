"""Where the symbols of a rule graph stand."""

from hypothesis import given
from hypothesis import strategies as st

from grammarlab.cli.rule_graph import RuleGraph, place_symbols, rule_graph
from grammarlab.language.grammar import Grammar


def graph_of(text):
    grammar = Grammar.parse(text)
    assert grammar.start_rule is not None
    return rule_graph(grammar.rules.values(), grammar.start_rule.name, frozenset({"extrude", "comp", "split", "NIL"}))


def test_edges_lead_from_rules_to_what_they_make_through_blocks_brackets_and_branches():
    graph = graph_of(
        """
        Lot --> extrude(3) [ Roof ] comp(f) { side : Wall | top : NIL }
        Wall --> 30% : Door else : split(x) { ~1 : Wall | { ~1 : Window }* }
        Wall(a) --> case a > 1 : Brick else : NIL
        """
    )
    made = {("Lot", "Roof"), ("Lot", "Wall"), ("Wall", "Wall"), ("Wall", "Door"), ("Wall", "Window"), ("Wall", "Brick")}
    assert set(graph.edges) == made
    leaves = dict.fromkeys(["Roof", "Door", "Window", "Brick"], "terminal")
    assert graph.kind == {"Lot": "start", "Wall": "stochastic", **leaves}


@given(st.sets(st.tuples(st.integers(0, 12), st.integers(0, 12)), max_size=40))
def test_placing_keeps_every_symbol_apart_and_edges_lead_right_unless_they_are_recursive(edges):
    graph = RuleGraph(
        dict.fromkeys([str(end) for edge in edges for end in edge], "rule"), [(str(a), str(b)) for a, b in edges]
    )
    reached = {symbol: set(others) for symbol, others in graph.neighbours().items()}
    for middle in graph.kind:
        for symbol in graph.kind:
            if middle in reached[symbol]:
                reached[symbol] |= reached[middle]
    placed = {p.symbol: p for p in place_symbols(graph)}
    assert set(placed) == set(graph.kind)
    assert len({(p.column, p.row) for p in placed.values()}) == len(placed)
    for a, b in graph.edges:
        if a in reached[b]:
            assert placed[a].column == placed[b].column
        else:
            assert placed[a].column < placed[b].column
