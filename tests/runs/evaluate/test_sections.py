"""Parts of a page with pictures."""

from grammarlab.runs.evaluate.pictures import ReportPicture, Section, copied_beside, markdown


def section(folder):
    for name in "abcd":
        (folder / f"{name}.jpg").write_bytes(name.encode())
    a, b, c, d = (ReportPicture(folder / f"{name}.jpg", f"the | {name}") for name in "abcd")
    return Section("Title", ((a,), (b, c)), "Remark.", (d,))


def test_pictures_stand_alone_or_side_by_side_and_large_ones_are_linked(tmp_path):
    (tmp_path / "grids").mkdir()
    assert markdown(section(tmp_path / "grids"), tmp_path) == (
        "## Title\n\n"
        "![the | a](grids/a.jpg)\n\n"
        "| the \\| b | the \\| c |\n| --- | --- |\n| ![the \\| b](grids/b.jpg) | ![the \\| c](grids/c.jpg) |\n\n"
        "Remark. Larger: [the | d](grids/d.jpg).\n"
    )


def test_a_heading_needs_nothing_below_its_picture(tmp_path):
    assert markdown(Section("A", ((ReportPicture(tmp_path / "a", "B"),),)), tmp_path) == "## A\n\n![B](a)\n"


def test_copies_lie_in_a_folder_of_the_name_of_the_page(tmp_path):
    (tmp_path / "docs").mkdir()
    (tmp_path / "grids").mkdir()
    page = tmp_path / "docs" / "results.md"
    copied = copied_beside(section(tmp_path / "grids"), page)
    assert {path.name: path.read_text() for path in (tmp_path / "docs" / "results").iterdir()} == {
        f"{name}.jpg": name for name in "abcd"
    }
    assert markdown(copied, page.parent) == markdown(section(tmp_path / "grids"), tmp_path).replace(
        "grids/", "results/"
    )
