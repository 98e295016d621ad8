"""``grammarlab show``."""

from __future__ import annotations

import re
from collections.abc import Container, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from grammarlab.cli.console import Library, friendly_errors, print_json, print_result, say, was_given
from grammarlab.cli.fitted_table import print_table, print_text
from grammarlab.cli.sample import complete_grammar, print_left_out, print_remarks
from grammarlab.errors import UsageError

if TYPE_CHECKING:
    from grammarlab.cli.rule_graph import RuleGraph
    from grammarlab.language.grammar import Grammar
    from grammarlab.language.syntax.syntax_tree import Attribute, Rule
    from grammarlab.runs.sample.shipped import RuleSource

_OF_A_MODEL = {
    "seed": "--seed",
    "attributes": "--attr",
    "start_rule": "--start",
    "footprint": "--footprint",
    "assets": "--assets",
    "tree": "--tree",
    "everything": "--all",
    "as_json": "--json",
}
"""Parameters that apply to one model only, with their options."""


def show(
    context: typer.Context,
    grammar: Annotated[
        str, typer.Argument(help="A .cga, .toml or .xml file, or a shipped name.", autocompletion=complete_grammar)
    ],
    graph: Annotated[
        Path | None,
        typer.Option("--graph", help="Draw the graph of the rules to this .svg or .png file.", dir_okay=False),
    ] = None,
    model: Annotated[
        int | None,
        typer.Option("--model", help="List how this model was made: its rules, or its measures."),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", help="Seed of the model.")] = 0,
    attributes: Annotated[
        list[str] | None, typer.Option("--attr", help="Value of an attribute, name=value; may be repeated.")
    ] = None,
    start_rule: Annotated[str, typer.Option("--start", help="Start rule.")] = "",
    footprint: Annotated[
        str, typer.Option("--footprint", help="20x12 (metres), WKT, or a map (GeoJSON and others).")
    ] = "",
    assets: Annotated[
        Path | None, typer.Option("--assets", help="Folder of assets. Default: the asset folder of the file.")
    ] = None,
    library: Library = None,
    tree: Annotated[
        Path | None,
        typer.Option(
            "--tree", help="Write the derivation tree of the model to this .svg or .html file.", dir_okay=False
        ),
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="List equal shapes one by one, or all parameters.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the tables, a model, or a species, as JSON.")] = False,
) -> None:
    """Show a grammar or a species as tables, or how a model was made.

    The tables list rules, symbols, attributes and probabilities; for species of trees, parameters and kinds.
    """
    with friendly_errors():
        from grammarlab.language.presets import RuleChoices
        from grammarlab.runs.sample.domains import SPECIES
        from grammarlab.runs.sample.shipped import find_rules

        source = find_rules(grammar, assets, RuleChoices(library))
        if source.suffix == SPECIES:
            from grammarlab.cli.show_species import show_species, show_tree

            _refuse_rule_options(context)
            if tree is not None:
                raise UsageError("--tree is about rules, and species of trees have none: leave it out.")
            if model is not None:
                show_tree(grammar, model, seed, attributes or (), assets, as_json)
                return
            _require_model(context, free=("everything", "as_json", "assets"))
            show_species(source, as_json, everything)
            return
        if model is not None:
            from grammarlab.runs.sample.trace import as_lines, as_values, trace_model

            if graph is not None:
                raise UsageError("--graph draws the rules, --model lists one model: give one of them.")
            options = attributes or (), start_rule, footprint, assets, library
            trace = trace_model(grammar, model, seed, *options)
            print_remarks(trace.remarks)
            _print_unread_imports(source)
            if tree is not None:
                from grammarlab.runs.sample.tree_drawing import save_tree

                save_tree(trace, tree, everything=everything)
                say(f"derivation tree: {tree}")
                return
            if as_json:
                print_json(as_values(trace))
                return
            for line in as_lines(trace, everything):
                print_result(line)
            return
        _require_model(context, free=("as_json",))
        _print_unread_imports(source)
        _show_rules(source, graph, as_json)


def _print_unread_imports(source: RuleSource) -> None:
    """Name the imports that are left in the text, since they cannot be read: what they define is not shown."""
    from grammarlab.language.grammar import Grammar
    from grammarlab.runs.sample.checks import unread_imports

    text = source.text()
    if re.search(r"\bimport\b", text):
        print_left_out(str(source.path), unread_imports(Grammar.parse(text, str(source.path))))


def _show_rules(source: RuleSource, graph: Path | None, as_json: bool) -> None:
    """Show a rule file as a drawing, as JSON or as tables."""
    from grammarlab.cli.rule_graph import rule_graph
    from grammarlab.language.grammar import Grammar
    from grammarlab.language.syntax.builtins import blocks, operations

    parsed = Grammar.parse(source.text(), str(source.path))
    start = parsed.start_rule
    names = frozenset(operations()) | frozenset(blocks()) | {"NIL"}
    symbols = rule_graph(parsed.rules.values(), start.name if start else "", names)
    if graph is not None:
        if as_json:
            raise UsageError("--graph draws the rules, --json prints them: give one of them.")
        _draw(symbols, graph)
        return
    counts = _counts(parsed, symbols)
    rules = _rule_rows(parsed.rules.values(), symbols)
    free = _attribute_rows(attribute for attribute in parsed.attributes.values() if not attribute.constant)
    if as_json:
        print_json({"file": parsed.file, "counts": counts, "rules": rules, "attributes": free})
        return
    print_result(parsed.file)
    print_text(", ".join(f"{name}: {count}" for name, count in counts.items()))
    if rules:
        _print_rules(rules)
    if free:
        _print_attributes(free)


def _require_model(context: typer.Context, free: Container[str] = ()) -> None:
    """Refuse options about one model where no model is given."""
    for name, option in _OF_A_MODEL.items():
        if name not in free and was_given(context, name):
            raise UsageError(f"{option} is about one model: say which, as in --model 17 --seed 5.")


def _refuse_rule_options(context: typer.Context) -> None:
    """Refuse options that need rules."""
    for name, option in {"graph": "--graph", "start_rule": "--start", "footprint": "--footprint"}.items():
        if was_given(context, name):
            raise UsageError(f"{option} is about rules, and species of trees have none: leave it out.")


def _draw(symbols: RuleGraph, path: Path) -> None:
    from grammarlab.cli.rule_graph import place_symbols, save_graph

    save_graph(place_symbols(symbols), symbols.edges, path)
    say(f"rule graph: {path}")


def _counts(grammar: Grammar, symbols: RuleGraph) -> dict[str, int]:
    """Numbers of the parts of a grammar, by their plural."""
    from grammarlab.language.syntax.syntax_tree import Stochastic, alternatives, walk

    leaves = sum(kind == "terminal" for kind in symbols.kind.values())
    branches = sum(len(list(alternatives(rule.body))) for rule in grammar.rules.values())
    choices = sum(isinstance(node, Stochastic) for node in walk(grammar.tree))
    constants = sum(attribute.constant for attribute in grammar.attributes.values())
    return {
        "symbols": len(symbols.kind),
        "leaf symbols": leaves,
        "rules": len(grammar.rules),
        "branches": branches,
        "attributes": len(grammar.attributes) - constants,
        "constants": constants,
        "functions": len(grammar.functions),
        "random choices": choices,
    }


def _attribute_rows(attributes: Iterable[Attribute]) -> list[dict[str, Any]]:
    """The attributes as plain values."""
    from grammarlab.language.syntax.printing import expression, value

    rows: list[dict[str, Any]] = []
    for attribute in attributes:
        notes = {
            note.name.lower(): ", ".join(
                f"{key}={expression(v)}" if key else expression(v) for key, v in note.arguments
            )
            for note in attribute.annotations
        }
        rows.append(
            {
                "attribute": attribute.name,
                "value": value(attribute.value),
                "range": notes.get("range", "") or notes.get("enum", ""),
                "group": notes.get("group", "").replace('"', ""),
                "description": notes.get("description", "").strip('"'),
                "line": attribute.location.line,
            }
        )
    return rows


def _print_attributes(rows: list[dict[str, Any]]) -> None:
    columns = {name.capitalize(): [row[name] for row in rows] for name in rows[0]}
    print_table("Attributes", columns, ("Attribute", "Group"))


def _rule_rows(rules: Iterable[Rule], symbols: RuleGraph) -> list[dict[str, Any]]:
    """The rules as plain values."""
    leads_to = symbols.neighbours()
    rows: list[dict[str, Any]] = []
    for rule in rules:
        probabilities, branches = _probabilities(rule)
        rows.append(
            {
                "rule": rule.name,
                "parameters": list(rule.parameters),
                "start": symbols.kind[rule.name] == "start",
                "branches": branches,
                "probabilities": probabilities,
                "leads to": sorted(leads_to[rule.name]),
                "line": rule.location.line,
            }
        )
    return rows


def _print_rules(rows: list[dict[str, Any]]) -> None:
    columns = {
        "Rule": [_called(row) for row in rows],
        "Branches": [row["branches"] for row in rows],
        "Probabilities": [row["probabilities"] for row in rows],
        "Leads to": [", ".join(row["leads to"]) for row in rows],
        "Line": [row["line"] for row in rows],
    }
    print_table("Rules", columns, ("Rule", "Leads to"))


def _called(row: dict[str, Any]) -> str:
    """Name of a rule with its mark and parameters, and blanks where lines may end."""
    parameters = f" ({', '.join(row['parameters'])})" if row["parameters"] else ""
    return f"{'@StartRule ' if row['start'] else ''}{row['rule']}{parameters}"


def _probabilities(rule: Rule) -> tuple[str, int]:
    """Percentages of each stochastic choice of a rule in the order of the text, with its number of branches."""
    from grammarlab.language.checking.percentages import constant
    from grammarlab.language.syntax.printing import expression
    from grammarlab.language.syntax.syntax_tree import Stochastic, alternatives, walk

    choices = []
    for choice in (node for node in walk(rule) if isinstance(node, Stochastic)):
        stated = [None if p is None else constant(p) for p in choice.percentages]
        rest = max(0.0, 100.0 - sum(number for number in stated if number is not None))
        all_constant = all(
            number is not None for p, number in zip(choice.percentages, stated, strict=True) if p is not None
        )
        words = [
            (f"{rest:.3g}" if all_constant else "else")
            if p is None
            else expression(p)
            if number is None
            else f"{number:.3g}"
            for p, number in zip(choice.percentages, stated, strict=True)
        ]
        choices.append(" / ".join(words) + " %")
    return "; ".join(choices), len(list(alternatives(rule.body)))
