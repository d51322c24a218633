"""What a section of the report holds: text, tables and plots, and the numbers that others may want."""

from dataclasses import dataclass, field


@dataclass
class Text:
    """A paragraph; HTML is allowed in it."""

    html: str


@dataclass
class Table:
    """A table: also written as NAME.csv. Cells are numbers (given `decimals` by column) or text; None is an empty cell."""

    name: str
    caption: str
    headings: list
    rows: list
    decimals: list | None = None
    # Rows of the paper's own figures, by number: shown apart.
    paper_rows: frozenset = frozenset()


@dataclass
class Plot:
    """A matplotlib figure: also written as NAME.svg and NAME.png."""

    name: str
    caption: str
    figure: object


@dataclass
class Section:
    """`numbers` go into results.json under the section's name: keys to numbers, or to such objects again."""

    name: str
    title: str
    blocks: list = field(default_factory=list)
    numbers: dict = field(default_factory=dict)

    def text(self, html):
        self.blocks.append(Text(html))

    def table(self, *args, **kwargs):
        self.blocks.append(Table(*args, **kwargs))

    def plot(self, *args):
        self.blocks.append(Plot(*args))
