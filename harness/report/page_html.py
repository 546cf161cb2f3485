"""A report as one HTML file that needs nothing else: charts inline, pictures as data URIs.

It is well-formed XML too, so that it can be checked.
"""
import base64
import html
import os
import re

import page_blocks as blocks
from record_files import read_bytes

HERE = os.path.dirname(os.path.abspath(__file__))


def escape(text):
    return html.escape(text, quote=True)


def inline(text):
    """Escaped, with `code` as such."""
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", escape(text))


def inline_svg(text, prefix):
    """An SVG file of matplotlib as an element: black becomes the page's ink, white its paper, ids its own."""
    text = text[text.index("<svg"):]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r' xmlns(:\w+)?="[^"]*"', "", text)
    text = re.sub(r'\bid="', f'id="{prefix}-', text)
    text = text.replace("url(#", f"url(#{prefix}-").replace('xlink:href="#', f'href="#{prefix}-')
    text = text.replace("stroke: #000000", "stroke: currentColor").replace("fill: #ffffff", "fill: none")
    return text.replace("<svg ", '<svg fill="currentColor" role="img" ', 1)


class HtmlPage:
    """Writes blocks; `folder` is where their files are."""

    def __init__(self, folder):
        self.folder = folder
        self.charts = 0

    def read(self, path):
        if ".." in path.split("/"):
            raise ValueError(f'"{path}" is not below the folder of the report')
        return read_bytes(os.path.join(self.folder, path))

    def text(self, block):
        return f"<p>{inline(block.text)}</p>"

    def cards(self, block):
        cards = "".join(
            f'<div class="card"><div class="figure">{escape(c.figure)}</div><div class="label">{inline(c.label)}</div>'
            f'<div class="detail">{inline(c.detail)}</div></div>' for c in block.cards)
        return f'<div class="cards">{cards}</div>'

    def table(self, block):
        head = "".join(f'<th scope="col">{inline(h)}</th>' for h in block.head)
        rows = []
        for index, row in enumerate(block.rows):
            cells = [c if isinstance(c, blocks.Cell) else blocks.Cell(c) for c in row]
            texts = [f'<th scope="row">{inline(cells[0].text)}</th>']
            texts += [f'<td{self.tone(c)}>{inline(c.text)}</td>' for c in cells[1:]]
            ours = ' class="ours"' if index in block.strong else ""
            rows.append(f"<tr{ours}>{''.join(texts)}</tr>")
        caption = f"<figcaption>{inline(block.caption)}</figcaption>" if block.caption else ""
        return (f'<figure><div class="scroll" tabindex="0"><table><thead><tr>{head}</tr></thead>'
                f"<tbody>{''.join(rows)}</tbody></table></div>{caption}</figure>")

    def tone(self, cell):
        return f' class="{cell.tone}"' if cell.tone else ""

    def chart(self, block):
        self.charts += 1
        svg = inline_svg(self.read(block.path).decode(), f"c{self.charts}")
        return f'<figure class="scroll chart" tabindex="0" aria-label="{escape(block.caption)}">{svg}</figure>'

    def pictures(self, block):
        figures = []
        for picture in block.pictures:
            data = base64.b64encode(self.read(picture.path)).decode()
            figures.append(
                f'<figure><img src="data:image/png;base64,{data}" alt="{escape(picture.title)}" />'
                f"<figcaption><strong>{inline(picture.title)}</strong> {inline(picture.caption)}</figcaption></figure>")
        caption = f"<p class=\"note\">{inline(block.caption)}</p>" if block.caption else ""
        return f'<div class="pictures">{"".join(figures)}</div>{caption}'

    def commands(self, block):
        return "".join(f'<p class="what">{inline(what)}</p><pre tabindex="0"><code>{escape(command)}</code></pre>'
                       for what, command in block.commands)

    def fold(self, block):
        is_open = ' open="open"' if block.is_open else ""
        return (f"<details{is_open}><summary>{inline(block.title)}</summary>"
                f"{''.join(self.write(b) for b in block.blocks)}</details>")

    def section(self, block):
        inner = "".join(self.write(b) for b in block.blocks)
        return f'<section id="{block.key}"><h2>{inline(block.title)}</h2>{inner}</section>'

    def write(self, block):
        return getattr(self, type(block).__name__.lower())(block)


def html_page(title, subtitle, sections, folder):
    """The whole page as text."""
    page = HtmlPage(folder)
    with open(os.path.join(HERE, "page.css"), encoding="utf-8") as file:
        style = file.read()
    links = "".join(f'<li><a href="#{s.key}">{inline(s.title)}</a></li>' for s in sections)
    body = "".join(page.write(s) for s in sections)
    return (f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8" />'
            f'<meta name="viewport" content="width=device-width, initial-scale=1" />'
            f'<meta name="color-scheme" content="light dark" /><title>{escape(title)}</title>'
            f"<style>{style}</style></head><body>"
            f'<nav aria-label="Contents"><p>{escape(title)}</p><ol>{links}</ol></nav>'
            f"<main><header><h1>{escape(title)}</h1><p>{inline(subtitle)}</p></header>{body}</main></body></html>\n")
