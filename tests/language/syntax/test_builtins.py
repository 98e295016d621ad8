"""The tables of what CGA has of its own."""

import re

import pytest

from grammarlab.language.checking.check import check_text
from grammarlab.language.syntax import builtins
from grammarlab.language.syntax.keywords import KEYWORDS

TYPES = {"float", "bool", "string", "any", "size", "tile", "place", "float[]", "bool[]", "string[]"}
FORMS = [
    form
    for table in (builtins.operations(), builtins.blocks(), builtins.functions())
    for forms in table.values()
    for form in forms
]
EXAMPLES = {"float": "1", "size": "'1", "tile": "~1", "bool": "true", "string": '"s"', "any": "1", "place": "a"}
EXAMPLES |= {"float[]": "[1]", "bool[]": "[true]", "string[]": '["s"]'}


def test_every_line_of_the_tables_is_read():
    for table, forms in (
        (builtins._OPERATIONS, builtins.operations()),
        (builtins._BLOCKS, builtins.blocks()),
        (builtins._FUNCTIONS, builtins.functions()),
    ):
        assert len(re.findall(r"\(", table)) == sum(map(len, forms.values()))


def test_types_and_keyword_sets_exist():
    for form in FORMS:
        for parameter in form.parameters:
            assert parameter.keywords or set(parameter.types) <= TYPES
        assert set(form.result) <= TYPES
        assert form.heads is None or form.heads == "size" or form.heads in KEYWORDS


def test_what_may_be_left_out_stands_last():
    for form in FORMS:
        optional = [parameter.optional for parameter in form.parameters]
        assert optional == sorted(optional)


def test_no_name_is_in_two_tables_of_operations():
    assert not builtins.operations().keys() & builtins.blocks().keys()


@pytest.mark.parametrize(
    "form", [form for forms in builtins.operations().values() for form in forms], ids=lambda form: form.name
)
def test_every_form_of_an_operation_passes_the_checker_with_each_of_its_keywords(form):
    choices = [sorted(parameter.keywords) or [EXAMPLES[parameter.types[0]]] for parameter in form.parameters]
    for index, words in enumerate(choices):
        for word in words:
            given = [word if i == index else other[0] for i, other in enumerate(choices)]
            text = f"attr a = 1\nLot --> {form.name}({', '.join(given)})"
            assert [finding.message for finding in check_text(text)] == []


@pytest.mark.parametrize(
    "form", [form for forms in builtins.functions().values() for form in forms], ids=lambda form: form.name
)
def test_every_form_of_a_function_passes_the_checker(form):
    given = [sorted(p.keywords)[0] if p.keywords else EXAMPLES[p.types[0]] for p in form.parameters]
    text = f"attr a = {form.name}({', '.join(given)})\nLot --> NIL"
    assert [finding.message for finding in check_text(text)] == []
