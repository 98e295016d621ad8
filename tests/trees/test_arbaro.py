"""Parameter files of Arbaro: read, written, and refused in words."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import LanguageError
from grammarlab.trees.arbaro import LABELS, MAX_CHARACTERS, check_arbaro, read_arbaro, write_arbaro
from grammarlab.trees.parameters import COLUMN, COLUMNS, DEFAULTS, HIGH, IS_INTEGER, LOW, PARAMETERS
from grammarlab.trees.species import Kind, Species
from tests.cases import bulk

TEXT = """<?xml version='1.0' ?>
<arbaro>
  <species name='ash'>
    <!-- <param name='Levels' value='9'/> -->
    <param name='Shape' value='7'/>
    <param name='Levels' value='3'/>
    <param name='Scale' value='13.0'/>
    <param name='ScaleV' value='3'/>
    <param name='LeafShape' value='disc3'/>
    <param name='Smooth' value='0.5'/>
    <param name='LeafDistrib' value='4'/>
    <param name='0Scale' value='0.9'/>
    <param name='0BaseSplits' value='2'/>
    <param name='1CurveV' value='-5e1'/>
    <param name='2BranchDist' value='0.2'/>
  </species>
</arbaro>
"""


def with_param(line: str) -> str:
    return TEXT.replace("  </species>", f"    {line}\n  </species>")


def test_values_are_those_of_the_file_and_otherwise_the_defaults_of_arbaro():
    species = read_arbaro(TEXT, "folder/ash.xml")
    assert species.name == "ash"
    values = dict(zip(COLUMNS, species.typical, strict=True))
    named = {"shape": 7, "levels": 3, "scale": 13, "scale_v": 3, "leaf_shape": 0, "scale_0": 0.9, "base_splits": 2}
    defaults = {"ratio": 0.05, "branches_1": 10, "branches_2": 5, "length_2": 0.5, "down_angle_2": 30, "curve_res_2": 1}
    for name, value in {**named, **defaults, "curve_1_v": -50, "flare": 0.5, "wind_speed": 0}.items():
        assert values[name] == value, name
    for name in ("branches_3", "length_3", "leaf_scale_x"):
        assert values[name] == PARAMETERS[name].default, name
    (kind,) = species.kinds
    assert kind.low.tolist() == kind.high.tolist() == species.typical.tolist()


def test_what_has_no_counterpart_is_listed():
    assert read_arbaro(TEXT, "ash.xml").about == (
        "'ash' of an Arbaro file; without counterpart here: Smooth = 0.5, 2BranchDist = 0.2."
    )
    findings = check_arbaro(TEXT, "ash.xml")
    assert [(finding.severity, finding.location.line) for finding in findings] == [("warning", 10), ("warning", 15)]
    palm = TEXT.replace("disc3", "needle")
    assert "LeafShape = 'needle' becomes a disc" in [finding.message for finding in check_arbaro(palm, "ash.xml")]
    assert read_arbaro(palm, "ash.xml").typical[COLUMN["leaf_shape"]] == 0


def test_parameters_of_other_programs_are_listed():
    text = with_param(
        "<param name='BarkTexture' value='bark.jpg'/><param name='LeafTextureRotation' value='4'/><param value=''/>"
    )
    others = "BarkTexture = bark.jpg, LeafTextureRotation = 4,  = ."
    assert read_arbaro(text, "ash.xml").about.endswith(others)
    assert {finding.severity for finding in check_arbaro(text, "ash.xml")} == {"warning"}


def test_a_file_of_another_program_with_many_parameters_is_refused():
    others = "".join(f"<param name='other {number}' value='1'/>" for number in range(60))
    with pytest.raises(LanguageError, match="reading ends after 50 remarks"):
        read_arbaro(with_param(others), "ash.xml")


def test_comments_and_line_ends_move_no_place():
    broken = with_param("<param name='Ratio' value='x'/>").replace(
        "    <!--", "<!-- two\nlines --> <!-- <param/> -->\n    <!--"
    )
    for text in (broken, "\ufeff" + broken, broken.replace("\n", "\r\n")):
        (finding,) = (finding for finding in check_arbaro(text, "ash.xml") if finding.severity == "error")
        assert (finding.location.line, finding.location.column) == (18, 5)


@bulk(30)
@given(st.integers(0, 2**32))
def test_written_files_are_read_again(seed: int):
    shares = np.random.default_rng(seed).uniform(size=len(COLUMNS))
    typical = LOW + shares * (HIGH - LOW)
    typical = np.where(IS_INTEGER, np.round(typical), typical)
    for column in set(COLUMNS) - set(LABELS.values()):
        typical[COLUMN[column]] = DEFAULTS[COLUMN[column]]
    species = Species("a <b> & 'c'", (Kind(1.0, typical, typical),), typical)
    text = write_arbaro(species)
    assert "<!--" not in text
    assert read_arbaro(text, "ash.xml").typical.tolist() == typical.tolist()


def test_what_arbaro_lacks_is_a_comment_of_the_written_file():
    low, high = DEFAULTS.copy(), DEFAULTS.copy()
    high[COLUMN["scale"]] = 20.0
    typical = DEFAULTS.copy()
    typical[COLUMN["blossom_rate"]] = 0.5
    kinds = (Kind(0.5, low, high), Kind(0.5, low, low))
    comments = re.findall("Arbaro: (.*) -->", write_arbaro(Species("ash", kinds, typical, acceptance="1")))
    assert comments == ["2 kinds", "scale from 12 to 20", "blossom_rate = 0.5", "an acceptance rule"]


MISTAKES = {
    "<param name='Ratio' value='nan'/>": ("not-finite", "0.001 to 0.3"),
    "<param name='Ratio' value='-Infinity'/>": ("not-finite", "0.001 to 0.3"),
    "<param name='1Branches' value='1000000000'/>": ("out-of-range", "0 to 2000"),
    "<param name='1Branches' value='1e9'/>": ("out-of-range", "1Branches"),
    "<param name='1Branches' value='2.5'/>": ("not-whole", "a whole number"),
    "<param name='Ratio' value='thick'/>": ("wrong-type", "'thick'"),
    "<param name='Ratio' value=''/>": ("wrong-type", "a number for Ratio"),
    "<param name='Ratio'/>": ("missing", "a value of 'Ratio'"),
    "<param name='LeafQualty' value='3'/>": ("unknown-name", "did you mean LeafQuality?"),
    "<param name='Levels' value='3'/>": ("repeated", "Levels"),
    "<param name='Smooth' value='0.5'/>": ("repeated", "Smooth"),
    "<param name='1Curv' value='3'/>": ("unknown-name", "1Curve"),
}


@pytest.mark.parametrize("line", MISTAKES)
def test_a_mistake_has_its_place_and_says_what_is_expected(line: str):
    code, advice = MISTAKES[line]
    with pytest.raises(LanguageError) as error:
        read_arbaro(with_param(line), "ash.xml")
    (finding,) = error.value.findings
    assert (finding.code, finding.location.line, finding.location.column) == (code, 16, 5)
    assert advice in finding.message + finding.hint


def test_too_many_levels_are_refused_in_the_words_of_the_file():
    with pytest.raises(LanguageError, match="expected Levels within 1 to 4, found 9"):
        read_arbaro(TEXT.replace("'3'/>\n    <param name='Scale'", "'9'/>\n    <param name='Scale'"), "ash.xml")


LAUGHS = (
    "<!DOCTYPE lolz [<!ENTITY a0 'lol'>"
    + "".join(f"<!ENTITY a{n} '{f'&a{n - 1};' * 10}'>" for n in range(1, 10))
    + "]><arbaro><species name='&a9;'/></arbaro>"
)
OUTSIDE = '<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/hostname">]><arbaro><species name="b">&b;</species></arbaro>'


@pytest.mark.parametrize(
    "text",
    [
        "",
        "<arbaro>",
        "<arbaro/>",
        "<arbaro><species/></arbaro>",
        "<arbaro><species/><species/></arbaro>",
        "<svg/>",
        "not XML",
        LAUGHS,
        OUTSIDE,
        "<!DOCTYPE arbaro><arbaro/>",
        "<a>" * 300_000,
        "<arbaro><species>" + "<param/>" * 100_000 + "</species></arbaro>",
        "<arbaro><species>" + "<param name='Scale' value='1'/>" * 9_000 + "</species></arbaro>",
        "<arbaro><species>" + "<param name='Ratio' value='" + "9" * 900_000 + "'/></species></arbaro>",
        "<!--" * 200_000,
        "<arbaro><species><param/><![CDATA[" + "<!--" * 200_000 + "]]></species></arbaro>",
        "x" * (MAX_CHARACTERS + 1),
        "\ud800",
    ],
    ids=str.__len__,
)
def test_other_and_hostile_files_are_refused_in_words(text: str):
    with pytest.raises(LanguageError) as error:
        read_arbaro(text, "ash.xml")
    assert len(str(error.value)) < 60_000
    assert error.value.findings == check_arbaro(text, "ash.xml")


@bulk(300)
@given(st.integers(0, len(TEXT)), st.integers(0, 30), st.text(max_size=6))
def test_edited_files_are_read_or_refused(start: int, length: int, new: str):
    text = TEXT[:start] + new + TEXT[start + length :]
    errors = [finding for finding in check_arbaro(text, "ash.xml") if finding.severity == "error"]
    if errors:
        with pytest.raises(LanguageError):
            read_arbaro(text, "ash.xml")
    else:
        species = read_arbaro(text, "ash.xml")
        assert ((species.typical >= LOW) & (species.typical <= HIGH)).all()
