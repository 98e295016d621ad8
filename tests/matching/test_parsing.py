"""Template text: its meaning, and messages on mistakes."""

import numpy as np
import pytest

from grammarlab.errors import LanguageError, UsageError
from grammarlab.matching.library import shipped, templates_by_name
from grammarlab.matching.template import points_along, stack
from grammarlab.matching.template_text import parse_templates

SIZE = "param width 1 (0.5 to 2) param height 1.5 (0.5 to 3)"


def test_templates_are_shipped_and_their_usual_sizes_meet_their_constraints():
    assert len({template.base for template in shipped()}) == 61
    for template in shipped():
        assert (template.limits[:, 0] + template.limits[:, 1:] @ template.usual >= -1e-9).all(), template.name
        drawn = points_along(template, template.usual)
        assert np.isfinite(drawn).all()
        assert np.linalg.norm(drawn[:, 1] - drawn[:, 0], axis=1).min() > 1e-3


def test_arcs_lie_on_their_circle():
    (arch,) = templates_by_name("arch")
    drawn = points_along(arch, np.array([1.0, 2.0]))
    top = drawn[3:].reshape(-1, 2) - [0.5, 1.5]
    assert np.allclose(np.linalg.norm(top, axis=1), 0.5, atol=0.01)
    assert top[:, 1].max() > 0.49


def test_counts_make_a_template_for_each_value():
    made = parse_templates(
        f"template t {SIZE} count n 2 to 4 repeat i 1 to n - 1 line (width*i/n, 0) -> (width*i/n, height) end end"
    )
    assert [template.counts for template in made] == [(("n", 2),), (("n", 3),), (("n", 4),)]
    assert [len(template.wires) for template in made] == [1, 2, 3]
    assert stack(made).pieces.shape[:2] == (3, 4)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "empty"),
        ("template t", "syntax"),
        ("template t end", "no-size"),
        (f"template t {SIZE} end", "no-wires"),
        (f"template t {SIZE} line (0, 0) -> (1, 1) end", "no-parameters"),
        (f"template t {SIZE} line (0, 0) -> (width*height, 1) end", "linear"),
        (f"template t {SIZE} line (0, 0) -> (width/0, 1) end", "linear"),
        (f"template t {SIZE} line (0, 0) -> (wdth, 1) end", "unknown-name"),
        (f"template t {SIZE} require width >= 5 line (0, 0) -> (width, 1) end", "contradiction"),
        ("template t param width 3 (0.5 to 2) param height 1 (0.5 to 3) line (0,0) -> (width,0) end", "range"),
        (f"template t {SIZE} line (0, 0) -> (width*1e9, 1) end", "too-large"),
        (f"template t {SIZE} repeat i 1 to 999 line (0, 0) -> (width, i) end end", "too-many"),
        (f"template t {SIZE} line (0, 0) -> (width, 1) end " * 2, "twice"),
        ("template t param width " + "(" * 5000 + "1", "syntax"),
        (f"template t {SIZE} line (0, 0) -> (width{'+0' * 5000}, 1) end", "too-deep"),
        (f"template t {SIZE} line (0, 0) -> (width*1e999, 1) end", "too-large"),
        (f"template t {SIZE} {'count n 0 to 20 ' * 2} line (0, 0) -> (width, 1) end", "twice"),
        (
            f"template t {SIZE} {' '.join(f'count n{i} 0 to 20' for i in range(9))} line (0, 0) -> (width, 1) end",
            "too-many",
        ),
        (f"template t {SIZE} {' '.join(f'repeat i{i} 1 to 99' for i in range(9))} {'end ' * 9} end", "too-many"),
        (f"template t {SIZE} {'require width <= height ' * 300} line (0, 0) -> (width, 1) end", "too-many"),
    ],
)
def test_mistakes_are_said_with_their_place(text, code):
    with pytest.raises(LanguageError) as error:
        parse_templates(text, "mine.template")
    assert error.value.findings[0].code == code
    assert "mine.template:" in str(error.value)


def test_unknown_names_of_templates_are_answered_with_near_ones():
    with pytest.raises(UsageError, match="rectangle"):
        templates_by_name("rectangel")
