"""A report as Markdown; charts and pictures are the files beside it."""
import page_blocks as blocks


def cell_text(cell):
    if not isinstance(cell, blocks.Cell):
        return cell.replace("|", "\\|")
    text = cell.text.replace("|", "\\|")
    return f"**{text}**" if cell.tone == "bad" else text


def table(block):
    lines = ["| " + " | ".join(block.head) + " |", "|---" + "|---:" * (len(block.head) - 1) + "|"]
    for index, row in enumerate(block.rows):
        cells = [cell_text(c) for c in row]
        if index in block.strong:
            cells[0] = f"**{cells[0]}**"
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + (f"\n\n{block.caption}" if block.caption else "")


def link_target(path):
    return path.replace(" ", "%20")


def write(block):
    if isinstance(block, blocks.Text):
        return block.text
    if isinstance(block, blocks.Cards):
        return "\n".join(f"- **{c.figure}** {c.label}: {c.detail}" for c in block.cards)
    if isinstance(block, blocks.Table):
        return table(block)
    if isinstance(block, blocks.Chart):
        return f"![{block.caption}]({link_target(block.path)})"
    if isinstance(block, blocks.Pictures):
        texts = [f"![{p.title}]({link_target(p.path)})\n\n**{p.title}** {p.caption}" for p in block.pictures]
        return "\n\n".join(texts + ([block.caption] if block.caption else []))
    if isinstance(block, blocks.Commands):
        return "\n\n".join(f"{what}\n\n```\n{command}\n```" for what, command in block.commands)
    if isinstance(block, blocks.Fold):
        return "\n\n".join([f"### {block.title}"] + [write(b) for b in block.blocks])
    return "\n\n".join([f"## {block.title}"] + [write(b) for b in block.blocks])


def markdown_page(title, subtitle, sections):
    """The whole page as text."""
    return "\n\n".join([f"# {title}", subtitle] + [write(s) for s in sections]) + "\n"
