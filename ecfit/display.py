"""How objects show themselves in notebooks: facts as a small table, every text escaped."""

from collections.abc import Iterable, Sequence
from html import escape


def facts(title: str, rows: Iterable[tuple[str, object]], note: str = "") -> str:
    """HTML of a title, label and value in rows, and a note below."""
    body = "".join(
        f'<tr><th style="text-align:left">{escape(str(k))}</th>'
        f'<td style="text-align:left">{escape(str(v))}</td></tr>'
        for k, v in rows
    )
    return f"<div><b>{escape(title)}</b><table>{body}</table>{_paragraph(note)}</div>"


def grid(
    title: str, header: Sequence[str], rows: Iterable[Sequence[object]], notes: Iterable[str] = ()
) -> str:
    """HTML of a title, notes, and a table with a header."""
    head = "".join(f"<th>{escape(h)}</th>" for h in header)
    body = "".join(f"<tr>{''.join(f'<td>{escape(str(c))}</td>' for c in row)}</tr>" for row in rows)
    said = "".join(map(_paragraph, notes))
    return f"<div><b>{escape(title)}</b>{said}<table><thead><tr>{head}</tr></thead>{body}</table></div>"


def _paragraph(text: str) -> str:
    return f"<p>{escape(text)}</p>" if text else ""
