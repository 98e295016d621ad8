"""Parts of a Markdown page that show pictures."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path

from grammarlab.files import atomic_file
from grammarlab.runs.markdown import table


@dataclass(frozen=True, slots=True)
class ReportPicture:
    """A picture for a page."""

    file: Path
    title: str
    """Title; printed above the picture if it has neighbours."""


@dataclass(frozen=True, slots=True)
class Section:
    """A heading and pictures below it."""

    title: str
    rows: tuple[tuple[ReportPicture, ...], ...]
    """Pictures side by side, row by row."""
    remark: str = ""
    """Text below the pictures."""
    linked: tuple[ReportPicture, ...] = ()
    """Pictures that are too large for the page."""


def markdown(section: Section, folder: Path) -> str:
    """A part of a page in a folder."""
    parts = [f"## {section.title}", *(_row(row, folder) for row in section.rows)]
    links = [f"[{picture.title}]({_link(picture, folder)})" for picture in section.linked]
    below = " ".join(filter(None, [section.remark, f"Larger: {', '.join(links)}." if links else ""]))
    return "\n\n".join([*parts, *filter(None, [below])]) + "\n"


def copied_beside(section: Section, page: Path) -> Section:
    """The part with copies of its pictures, in a folder next to a page, with the name of the page."""
    rows = tuple(tuple(_copied(picture, page.with_suffix("")) for picture in row) for row in section.rows)
    return replace(section, rows=rows, linked=tuple(_copied(other, page.with_suffix("")) for other in section.linked))


def _row(pictures: tuple[ReportPicture, ...], folder: Path) -> str:
    shown = [f"![{picture.title}]({_link(picture, folder)})" for picture in pictures]
    if len(shown) == 1:
        return shown[0]
    return table([picture.title for picture in pictures], [shown]).rstrip("\n")


def _link(picture: ReportPicture, folder: Path) -> str:
    return Path(os.path.relpath(picture.file, folder)).as_posix()


def _copied(picture: ReportPicture, folder: Path) -> ReportPicture:
    folder.mkdir(parents=True, exist_ok=True)
    with atomic_file(folder / picture.file.name) as part:
        part.write_bytes(picture.file.read_bytes())
    return replace(picture, file=folder / picture.file.name)
