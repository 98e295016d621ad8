"""Species files: every mistake has its place, and what is written is read again."""

import re
import sys
import tomllib

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from grammarlab.errors import Finding, LanguageError
from grammarlab.randomness import root_keys
from grammarlab.trees.parameters import COLUMN, COLUMNS, DEFAULTS, HIGH, IS_INTEGER, LOW, PARAMETERS, SPREAD
from grammarlab.trees.species import Kind, Look, Species, drawn
from grammarlab.trees.species_file import MAX_CHARACTERS, check, parse, write
from grammarlab.trees.species_tables import MOST_FINDINGS
from tests.cases import bulk

TEXT = """\
about = "A tree."
acceptance = "$scale < 12"

[look]
bark = "oak/bark.png"
leaf_color = "#416329"

[tree]
scale = { value = 13.0, spread = 3.0, range = [10.0, 16.0], unit = "m", why = "height" }
levels = 2

[level_1]
curve_1 = { value = 40.0, spread = -90.0, spread_range = [-110.0, -60.0], unit = "deg" }

[leaves]
leaves = { value = 12, range = [8, 20] }

[[kinds]]
weight = 3
means = "slender"
ranges = { ratio = [0.01, 0.02] }

[[kinds]]
weight = 1
[kinds.ranges]
scale = [4.0, 5.0]
curve_1_v = 30
"""


def bounds(species: Species, kind: int, column: str) -> tuple[float, float]:
    index = COLUMN[column]
    return float(species.kinds[kind].low[index]), float(species.kinds[kind].high[index])


def same(first: Species, second: Species) -> bool:
    """Whether two species are equal, every number exactly."""
    numbers = [
        [species.typical, *(array for kind in species.kinds for array in (kind.low, kind.high, kind.weight))]
        for species in (first, second)
    ]
    texts = [
        (species.name, species.look, species.about, dict(species.why), species.acceptance)
        for species in (first, second)
    ]
    means = [[kind.means for kind in species.kinds] for species in (first, second)]
    return texts[0] == texts[1] and means[0] == means[1] and all(map(np.array_equal, *numbers))


def test_a_file_says_what_a_person_would_read_in_it():
    species = parse(TEXT, "folder/ash.toml")
    assert (species.name, species.about, species.acceptance) == ("ash", "A tree.", "$scale < 12")
    assert species.why == {"scale": "height"}
    assert species.look == Look(bark="oak/bark.png", leaf_color=(0x41 / 255, 0x63 / 255, 0x29 / 255))
    assert [(kind.weight, kind.means) for kind in species.kinds] == [(0.75, "slender"), (0.25, "")]
    assert bounds(species, 0, "scale") == (10.0, 16.0)
    assert bounds(species, 1, "scale") == (4.0, 5.0)
    assert bounds(species, 0, "scale_v") == (3.0, 3.0)
    assert bounds(species, 0, "ratio") == (0.01, 0.02)
    assert bounds(species, 0, "curve_1_v") == (-110.0, -60.0)
    assert bounds(species, 1, "curve_1_v") == (30.0, 30.0)
    assert bounds(species, 1, "leaves") == (8.0, 20.0)
    expected = DEFAULTS.copy()
    for column, value in {
        "scale": 13,
        "scale_v": 3,
        "levels": 2,
        "curve_1": 40,
        "curve_1_v": -90,
        "leaves": 12,
    }.items():
        expected[COLUMN[column]] = value
    assert species.typical.tolist() == expected.tolist()


def test_sections_are_for_reading_only():
    lines = re.sub(r"^\[(tree|level_1|leaves)\]\n", "", TEXT, flags=re.MULTILINE).split("\n\n[look]")
    rest = lines[1].split("\n\n")
    flat = lines[0] + "\n" + "\n".join(rest[1:4]) + "\n\n[look]" + rest[0] + "\n\n" + "\n\n".join(rest[4:])
    assert "[tree]" not in flat
    assert same(parse(flat, "ash"), parse(TEXT, "ash"))


def columns_within(low: np.ndarray, high: np.ndarray, shares: np.ndarray) -> np.ndarray:
    values = low + shares * (high - low)
    return np.where(IS_INTEGER, np.round(values), values)


texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
colors = st.one_of(
    st.tuples(*[st.integers(0, 255).map(lambda octet: octet / 255)] * 3), st.tuples(*[st.floats(0.0, 1.0)] * 3)
)


@st.composite
def any_species(draw: st.DrawFn) -> Species:
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))

    def some_columns() -> np.ndarray:
        is_default = rng.uniform(size=len(COLUMNS)) < draw(st.sampled_from([0.0, 0.5, 1.0]))
        return np.where(is_default, DEFAULTS, columns_within(LOW, HIGH, rng.uniform(size=len(COLUMNS))))

    weights = rng.uniform(0.1, 1.0, draw(st.integers(1, 4)))
    shared = some_columns(), some_columns()
    kinds = []
    for weight in weights / weights.sum():
        ends = shared if draw(st.booleans()) else (some_columns(), some_columns())
        kinds.append(Kind(float(weight), np.minimum(*ends), np.maximum(*ends), draw(texts)))
    typical = columns_within(kinds[0].low, kinds[0].high, rng.uniform(size=len(COLUMNS)))
    why = draw(st.dictionaries(st.sampled_from(sorted(PARAMETERS)), texts.filter(bool), max_size=5))
    picture = st.sampled_from(["", "oak/bark.png", 'a "b".png'])
    look = Look(draw(picture), draw(picture), "", draw(colors), draw(colors), draw(colors))
    return Species("ash", tuple(kinds), typical, look, draw(texts), why, draw(texts))


@bulk(60)
@given(any_species())
def test_what_is_written_is_read_again_and_is_written_the_same(species: Species):
    text = write(species)
    read = parse(text, "ash.toml")
    scale = sum(kind.weight for kind in species.kinds)
    assert np.isclose(scale, 1.0)
    assert same(read, species)
    assert write(read) == text


def test_a_written_file_has_no_line_for_what_is_left_at_its_default():
    default = Species("ash", (Kind(1.0, DEFAULTS, DEFAULTS),), DEFAULTS)
    assert write(default) == "\n"
    assert write(parse("scale = { value = 12.0, unit = 'm' }\nlevels = 2", "ash")) == "[tree]\nlevels = 2\n"


def test_the_written_form_is_readable():
    assert write(parse(TEXT, "ash")) == (
        'about = "A tree."\n'
        'acceptance = "$scale < 12"\n\n'
        "[look]\n"
        'bark = "oak/bark.png"\n'
        'leaf_color = "#416329"\n\n'
        "[tree]\n"
        'scale = { value = 13.0, spread = 3.0, unit = "m", why = "height" }\n'
        "levels = 2\n\n"
        "[level_1]\n"
        'curve_1 = { value = 40.0, spread = -90.0, unit = "deg" }\n\n'
        "[leaves]\n"
        "leaves = { value = 12, range = [8, 20] }\n\n"
        '[[kinds]]\nweight = 0.75\nmeans = "slender"\n'
        "[kinds.ranges]\nscale = [10.0, 16.0]\nratio = [0.01, 0.02]\ncurve_1_v = [-110.0, -60.0]\n\n"
        "[[kinds]]\nweight = 0.25\n"
        "[kinds.ranges]\nscale = [4.0, 5.0]\ncurve_1_v = [30.0, 30.0]\n"
    )


def test_trees_differ_where_the_file_has_a_range_and_nowhere_else():
    rows, _ = drawn(parse(TEXT.split("[[kinds]]", maxsplit=1)[0], "ash"), root_keys(1, np.arange(50)))
    different = {COLUMNS[index] for index in np.flatnonzero(np.ptp(rows, axis=0))}
    assert different == {"scale", "curve_1_v", "leaves"}


MISTAKES = {
    "scal = 3": ("unknown-name", 1, "scal", "did you mean scale"),
    "curve_1_v = 3": ("unknown-name", 1, "curve_1_v", "write it as the spread of curve_1"),
    "levels = 9": ("out-of-range", 1, "9", "1 to 4"),
    "levels = 2.5": ("not-whole", 1, "2.5", "a whole number"),
    "levels = true": ("wrong-type", 1, "true", "1 to 4"),
    "ratio = nan": ("not-finite", 1, "nan", "0.001 to 0.3"),
    "ratio = inf": ("not-finite", 1, "inf", "0.001 to 0.3"),
    "branches_1 = 1000000000": ("out-of-range", 1, "1000000000", "0 to 2000"),
    "\nscale = 1e9": ("out-of-range", 2, "1e9", "0.05 to 120 m"),
    'scale = "tall"': ("wrong-type", 1, '"tall"', "0.05 to 120 m"),
    'scale = { value = 3.0, unit = "cm" }': ("wrong-unit", 1, '"cm"', '"m"'),
    'levels = { value = 3, unit = "m" }': ("wrong-unit", 1, '"m"', "no unit"),
    "scale = { range = [3, 4] }": ("missing", 1, "{", "a value"),
    "scale = { value = 5, range = [4, 3] }": ("reversed-range", 1, "[4, 3]", "[3, 4]"),
    "scale = { value = 5, range = [3, 4] }": ("outside-own-range", 1, "5", "3 to 4"),
    "scale = { value = 5, range = [3, 4, 5] }": ("wrong-type", 1, "[3, 4, 5]", "a range of scale"),
    "scale = { value = 5, spred = 1 }": ("unknown-name", 1, "spred", "did you mean spread?"),
    "levels = { value = 3, spread = 1 }": ("no-spread", 1, "spread", "a range"),
    "scale = { value = 5, spread = 100 }": ("out-of-range", 1, "100", "0 to 60 m"),
    "scale = 3\n[tree]\nscale = 4": ("repeated", 3, "scale", "delete one"),
    "[[kinds]]\nweight = 0": ("weight", 2, "0", "above 0"),
    "[[kinds]]\n[[kinds]]\nweight = nan": ("weight", 3, "nan", "above 0"),
    "kinds = []": ("wrong-type", 1, "[]", "1 to 256"),
    "[[kinds]]\nranges = { scal = 3 }": ("unknown-name", 2, "scal", "did you mean scale"),
    "[[kinds]]\n[kinds.ranges]\nscale = [1, nan]": ("not-finite", 3, "[1, nan]", "0.05 to 120 m"),
    '[look]\nbark = "../secret"': ("outside-folder", 2, '"../secret"', "below the asset folder"),
    '[look]\nbark_color = "#12345g"': ("wrong-type", 2, '"#12345g"', "#5c4836"),
    "[look]\nbark_colour = [0, 0, 1]": ("unknown-name", 2, "bark_colour", "did you mean bark_color"),
    "about = 3": ("wrong-type", 1, "3", "a text"),
    "scale = ": ("syntax", 1, "", "not TOML"),
}


@pytest.mark.parametrize("text", MISTAKES)
def test_a_mistake_has_its_place_and_says_what_is_expected(text: str):
    code, line, underlined, advice = MISTAKES[text]
    (finding,) = check(text, "ash.toml")
    place = finding.location
    shown = text.split("\n")[place.line - 1][place.column - 1 : place.column - 1 + place.length]
    assert (finding.code, finding.severity, place.line, place.file) == (code, "error", line, "ash.toml")
    assert shown.startswith(underlined) if underlined != "{" else shown
    assert advice in finding.message + finding.hint
    with pytest.raises(LanguageError) as error:
        parse(text, "ash.toml")
    assert error.value.findings == (finding,)


def test_all_mistakes_are_found_at_once():
    wrong = [text for text in MISTAKES if "\n" not in text and not text.startswith(("kinds", "about", "scale = \n"))]
    lines = {re.split(r"\W", text)[0]: text for text in wrong if text != "scale = "}
    codes = {finding.code for finding in check("\n".join(lines.values()), "ash.toml")}
    assert {MISTAKES[text][0] for text in lines.values()} <= codes
    assert len(check("\n".join(lines.values()), "ash.toml")) == len(lines)


@pytest.mark.parametrize(
    "text",
    [
        "a = " * 1 + "[" * 100_000,
        "a" + ".a" * 100_000 + " = 1",
        "[" + ".".join("a" * 50_000) + "]",
        "scale = " + "9" * 5_000,
        "scale = 0x" + "f" * 100_000,
        "".join(f"x{number} = 1\n" for number in range(50_000)),
        "".join("[[kinds]]\n" for _ in range(50_000)),
        "x" * (MAX_CHARACTERS + 1),
        "'" * 400_000,
        'about = "' + "a" * 500_000 + '"',
    ],
    ids=str.__len__,
)
def test_hostile_files_are_refused(text: str):
    findings = check(text, "ash.toml")
    assert 1 <= len(findings) <= MOST_FINDINGS
    assert len(str(LanguageError(findings, text))) < 100_000


def is_toml(text: str) -> bool:
    try:
        return bool(tomllib.loads(text)) or True
    except (ValueError, RecursionError):
        return False


@bulk(400)
@given(st.integers(0, len(TEXT)), st.integers(0, 30), st.text(max_size=6))
@example(0, 0, "")
def test_edited_files_are_read_or_refused_with_places(start: int, length: int, new: str):
    text = TEXT[:start] + new + TEXT[start + length :]
    findings = check(text, "ash.toml")
    errors = [finding for finding in findings if finding.severity == "error"]
    lines = text.split("\n")
    assert all(1 <= finding.location.line <= len(lines) for finding in findings)
    assert all(isinstance(finding, Finding) and finding.location.column >= 1 for finding in findings)
    if errors:
        with pytest.raises(LanguageError):
            parse(text, "ash.toml")
    else:
        species = parse(text, "ash.toml")
        assert same(parse(write(species), "ash.toml"), species)
        assert all((kind.low >= LOW).all() and (kind.high <= HIGH).all() for kind in species.kinds)
        assert is_toml(text)


def test_numbers_of_any_size_are_no_accident():
    digits = sys.get_int_max_str_digits()
    for number in ("1" * (digits + 1), "-" + "1" * 40, "1e400", "-1e400", "1e-400"):
        codes = {finding.code for finding in check(f"scale = {number}", "ash.toml")}
        assert len(codes) == 1
        assert codes <= {"syntax", "out-of-range", "not-finite"}


def test_spreads_have_names_of_their_own():
    assert [name for name in COLUMNS if name.endswith(SPREAD)] == [
        name + SPREAD for name, parameter in PARAMETERS.items() if parameter.spread is not None
    ]


CONTRADICTIONS = {
    "levels = 2\ncurve_2 = 30": ("curve_2", "levels the value 3"),
    "levels = 2\nattraction_up = 1": ("attraction_up", "levels the value 3"),
    "curve_back_1 = 30": ("curve_back_1", "curve_1 is 0"),
    "split_angle_1 = 30": ("split_angle_1", "seg_splits_1 is 0"),
    "split_angle_0 = 30": ("split_angle_0", "seg_splits_0 or base_splits"),
    "leaves = 3\nleaf_scale = 0": ("leaves", "leaf_scale is 0"),
    "leaf_scale = 1": ("leaf_scale", "leaves is 0"),
    "levels = 2\nbranches_1 = 0\nbase_size = 0.3": ("base_size", "branches_1 is 0"),
    "levels = 3\nbranches_1 = 0": ("branches_1", "no stems of level 2"),
    "prune_width = 1": ("prune_width", "prune_ratio is 0"),
    "lobe_depth = 0.1": ("lobe_depth", "lobes is 0"),
    "lobes = 5": ("lobes", "lobe_depth is 0"),
    "wind_direction = 90": ("wind_direction", "wind_speed is 0"),
    "blossom_rate = 0.5": ("blossom_rate", "leaves is 0"),
    "length_1 = { value = 0.3, spread = 0.4 }": ("length_1", "larger than its value"),
    "length_1 = 3": ("length_1", "3 times as long as their parent"),
    "levels = 2\nbranches_1 = 2000\nseg_splits_0 = 1\ncurve_res_0 = 11\nleaves = 0": (
        "branches_1",
        "stems of level 1",
    ),
    "levels = 3\nbranches_1 = 200\nbranches_2 = 100\nleaves = 120": ("leaves", "leaves, of 1,000,000"),
    "curve_1 = { value = 3, spread = 1, spread_range = [-1, 1] }": ("curve_1", "another meaning"),
}


@pytest.mark.parametrize("text", CONTRADICTIONS)
def test_parameters_that_contradict_each_other_are_told_apart_from_mistakes(text: str):
    name, advice = CONTRADICTIONS[text]
    (finding,) = check(text, "ash.toml")
    place = finding.location
    assert (finding.severity, finding.code) == ("warning", "contradiction")
    assert text.split("\n")[place.line - 1][place.column - 1 :].startswith(name)
    assert advice in finding.message + finding.hint
    parse(text, "ash.toml")


@pytest.mark.parametrize(
    "text",
    [
        "levels = 2\nleaves = 3\ndown_angle_2 = 30\nrotate_2 = 80",
        "levels = { value = 2, range = [2, 3] }\ncurve_2 = 30",
        "lobes = { value = 0, range = [0, 5] }\nlobe_depth = 0.1",
        "shape = 8\nprune_width = 1",
        "base_splits = 2\nsplit_angle_0 = 30",
        "curve_1 = { value = 0, range = [-10, 10] }\ncurve_back_1 = 30",
        "[[kinds]]\n[[kinds]]\nranges = { leaves = 3 }\n[leaves]\nleaf_scale = 1",
    ],
)
def test_what_has_an_effect_in_some_trees_is_no_contradiction(text: str):
    assert check(text, "ash.toml") == ()
