"""Parts of the trees of texts."""

from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.syntax_tree import Attribute, Rule, Sequence


def definitions(text):
    return Grammar.parse(text).tree.definitions


def rule_body(text):
    rule = definitions(text)[-1]
    assert isinstance(rule, Rule)
    return rule.body


def value(text):
    (attribute,) = definitions(f"attr x = {text}")
    assert isinstance(attribute, Attribute)
    return attribute.value


def items(text):
    body = rule_body(f"Lot --> {text}")
    assert isinstance(body, Sequence)
    return body.items
