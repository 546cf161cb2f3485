#!/usr/bin/env python3
"""What is wrong with a report: check_page.py DIR WORD...; a line for each, exit code 1 if there is any.

The HTML must be well-formed, load nothing, name nothing that is not in it, and hold every WORD; the Markdown too,
and its links must lead to files.
"""
import os
import re
import sys
import xml.etree.ElementTree as ElementTree


def html_problems(text, words):
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        yield f"not well-formed: {error}"
        return
    ids = [e.get("id") for e in root.iter() if e.get("id")]
    if len(ids) != len(set(ids)):
        yield "an id twice"
    for element in root.iter():
        if element.tag in ("script", "link", "iframe", "object", "embed"):
            yield f"<{element.tag}>"
        for name, value in element.attrib.items():
            if name == "src" and not value.startswith("data:image/png;base64,"):
                yield f"{name}={value[:60]}"
            if name == "href" and not (value.startswith("#") and value[1:] in ids):
                yield f"{name}={value[:60]} leads nowhere"
            if "url(" in value and re.search(r"url\((?!#)", value):
                yield f"{name}={value[:60]}"
            for target in re.findall(r"url\(#([^)]*)\)", value):
                if target not in ids:
                    yield f"url(#{target}) leads nowhere"
    if re.search(r"https?://|@import|xmlns", text):
        yield "an address in the page"
    shown = "".join(root.itertext())
    yield from (f"no word {word} in the HTML" for word in words if word not in shown)


def markdown_problems(text, folder, words):
    links = re.findall(r"\]\(([^)]*)\)", text)
    if not links:
        yield "no links in the Markdown"
    for link in links:
        if not os.path.isfile(os.path.join(folder, link.replace("%20", " "))):
            yield f"{link} is not there"
    yield from (f"no word {word} in the Markdown" for word in words if word not in text)


def main(folder, words):
    with open(os.path.join(folder, "index.html"), encoding="utf-8") as file:
        found = list(html_problems(file.read(), words))
    with open(os.path.join(folder, "report.md"), encoding="utf-8") as file:
        found += markdown_problems(file.read(), folder, words)
    for problem in found:
        print(problem)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
