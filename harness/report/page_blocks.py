"""What a report is made of, before it is written as HTML or as Markdown.

Texts hold `code` between backquotes and no other markup.
"""
from dataclasses import dataclass, field


@dataclass
class Text:
    text: str


@dataclass
class Cell:
    """A figure in a table; `tone` is "", "good" or "bad"."""

    text: str
    tone: str = ""


@dataclass
class Table:
    head: list
    rows: list  # of strings and Cells, the first of each row says what the row is
    caption: str = ""
    strong: set = field(default_factory=set)  # rows (by index) that are about ours


@dataclass
class Card:
    figure: str
    label: str
    detail: str


@dataclass
class Cards:
    cards: list


@dataclass
class Chart:
    path: str  # of an SVG file, below the report's folder
    caption: str


@dataclass
class Picture:
    path: str  # of a PNG file, below the report's folder
    title: str
    caption: str


@dataclass
class Pictures:
    pictures: list
    caption: str = ""


@dataclass
class Commands:
    commands: list  # of pairs: what it makes, the command line


@dataclass
class Fold:
    """Blocks that are shown when asked for, or from the start."""

    title: str
    blocks: list
    is_open: bool = False


@dataclass
class Section:
    key: str
    title: str
    blocks: list
