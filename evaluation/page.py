"""Sections written out: one HTML file with everything in it, and each table and plot as files of their own."""

import base64
import csv
import html
import io
import json
import math
from pathlib import Path

from . import report
from .store import write_whole

STYLE = (Path(__file__).parent / "page.css").read_text(encoding="utf-8")


def write(out, heading, sections, about=None):
    """`index.html`, `results.json`, a CSV for each table, an SVG and a PNG for each plot, below `out`.

    `about` is what results.json says of the run.
    """
    out = Path(out)
    for section in sections:
        for block in section.blocks:
            if isinstance(block, report.Table):
                write_whole(out / f"{block.name}.csv", as_csv(block))
            elif isinstance(block, report.Plot):
                for kind in kinds(block.figure):
                    (out / f"{block.name}.{kind}").write_bytes(rendered(block.figure, kind))
    numbers = {section.name: section.numbers for section in sections}
    if about is not None:
        numbers["about"] = about
    write_whole(out / "results.json", json.dumps(finite(numbers), indent=1, sort_keys=True) + "\n")
    write_whole(out / "index.html", page(heading, sections))


def page(heading, sections):
    contents = "".join(f'<li><a href="#{section.name}">{html.escape(section.title)}</a></li>' for section in sections)
    body = "".join(of_section(number, section) for number, section in enumerate(sections, 1))
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>flicr: the paper, re-done</title><style>{STYLE}</style></head><body>"
        f"<header>{heading}<nav><ol>{contents}</ol></nav></header><main>{body}</main></body></html>\n"
    )


def of_section(number, section):
    blocks = "\n".join(of_block(block) for block in section.blocks)
    return f'<section id="{section.name}"><h2>{number}. {html.escape(section.title)}</h2>\n{blocks}</section>\n'


def of_block(block):
    if isinstance(block, report.Text):
        return f"<p>{block.html}</p>"
    if isinstance(block, report.Table):
        return of_table(block)
    return of_plot(block)


def of_table(table):
    head = "".join(f"<th>{html.escape(heading)}</th>" for heading in table.headings)
    rows = "".join(of_row(table, number, row) for number, row in enumerate(table.rows))
    return (
        f'<figure class="table"><figcaption>{table.caption} <a class="file" href="{table.name}.csv">CSV</a></figcaption>'
        f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div></figure>'
    )


def of_row(table, number, row):
    kind = ' class="paper"' if number in table.paper_rows else ""
    cells = "".join(f"<td{kind_of(table, column, cell)}>{html.escape(shown(table, column, cell))}</td>" for column, cell in enumerate(row))
    return f"<tr{kind}>{cells}</tr>"


def kind_of(table, column, cell):
    """To the right what is a number, or a word in a column of numbers."""
    of_numbers = bool(table.decimals) and table.decimals[column] is not None
    return ' class="number"' if of_numbers or isinstance(cell, (int, float)) or cell is None else ""


def shown(table, column, cell):
    """A cell's text: thousands with commas, decimals by column."""
    if cell is None:
        return "–"
    if isinstance(cell, str):
        return cell
    if math.isinf(cell):
        return "exact"
    decimals = table.decimals[column] if table.decimals else None
    return f"{cell:,.{decimals}f}" if decimals is not None else f"{cell:g}"


def kinds(figure):
    """Formats that a figure is written in: a cloud of points, marked as a picture, is no drawing of lines."""
    return ("png",) if getattr(figure, "is_picture", False) else ("svg", "png")


def of_plot(plot):
    if kinds(plot.figure) == ("png",):
        data = base64.b64encode(rendered(plot.figure, "png")).decode()
        image = f'<img alt="{html.escape(plot.name)}" src="data:image/png;base64,{data}">'
    else:
        svg = rendered(plot.figure, "svg").decode()
        image = svg[svg.index("<svg"):]
    return f'<figure class="plot" id="{plot.name}">{image}<figcaption>{plot.caption}</figcaption></figure>'


def rendered(figure, kind):
    """The bytes of a figure, drawn once."""
    kept = figure.__dict__.setdefault("_rendered", {})
    if kind not in kept:
        kept[kind] = drawn(figure, kind)
    return kept[kind]


def drawn(figure, kind):
    out = io.BytesIO()
    figure.savefig(out, format=kind, dpi=150, bbox_inches="tight", metadata={"Date": None} if kind == "svg" else None)
    return out.getvalue()


def as_csv(table):
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(table.headings)
    writer.writerows(["" if cell is None else cell for cell in row] for row in table.rows)
    return out.getvalue()


def finite(value):
    """Infinite numbers as null, as JSON has it."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
