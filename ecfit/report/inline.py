"""Matplotlib's SVG made part of a page: smaller, in the page's colours and font, its ids unique."""

import base64
import html
import io
import re
from collections.abc import Sequence

from PIL import Image

from ecfit.report.style import COLOURS, INK

# The colours of `style.COLOURS` as the page names them: it has others where it is dark.
_NAMED = {name: f"var(--{name})" for name in ("polynomial", "rational", "other", "table")}
_THEME = {
    INK: "currentColor",
    "#ffffff": "var(--paper)",
    **{COLOURS[name].lower(): variable for name, variable in _NAMED.items()},
}
# Of a figure that fills the page, in points (9.6 inches).
_FULL_WIDTH = 691.2
# Colours of an image within a figure: steps that are not seen, and a third of the weight.
_SHADES = 64


def inline(svg: bytes, prefix: str, label: str) -> str:
    """An SVG file as an element: ids start with `prefix`, and `label` is what a screen reader says."""
    text = svg.decode("utf-8")
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.S)
    # A style sheet within would hold for the whole page; its two rules are in the page's own.
    text = re.sub(r"<style.*?</style>", "", text, flags=re.S)
    # Hundredths of a point are not seen, but weigh a third of the page; names of fonts and ids another.
    # Within tags only: labels keep their digits.
    text = re.sub(r"<[^>]*>", lambda tag: re.sub(r"(\d\.\d\d)\d+", r"\1", tag[0]), text)
    text = re.sub(r"font-family: [^;\"]+;? ?", "", text)
    text = re.sub(r"(font: \d[^ ]*) [^;\"]+", r"\1 sans-serif", text)
    text = re.sub(r'(data:image/png;base64,)([^"]+)', lambda m: m[1] + _indexed(m[2]), text)
    text = re.sub(r">\s+<", "><", text)
    text = re.sub(r"\s*\n\s*", " ", text)
    for colour, themed in _THEME.items():
        text = re.sub(re.escape(colour) + r"\b", themed, text, flags=re.I)
    text = re.sub(r"<!--.*?-->| transform=\"rotate\(-0 [^\"]*\"", "", text, flags=re.S)
    used = list(dict.fromkeys(re.findall(r'(?:url\(#|href="#)([^")]+)', text)))
    ids = {name: f"{prefix}{i}" for i, name in enumerate(used)}
    text = re.sub(r' id="([^"]+)"', lambda m: f' id="{ids[m[1]]}"' if m[1] in ids else "", text)
    text = re.sub(r'(url\(#|href="#)([^")]+)', lambda m: m[1] + ids[m[2]], text)
    # As wide as the page only where it was drawn so wide: text has one size in all.
    width = re.search(r'width="([\d.]+)pt"', text)
    share = min(100.0, 100.0 * float(width[1]) / _FULL_WIDTH) if width else 100.0
    said = f'<svg role="img" aria-label="{html.escape(label)}" style="max-width: {share:.0f}%"'
    return text.replace("<svg", said, 1)


def _indexed(encoded: str) -> str:
    """A PNG with a palette of `_SHADES`; as it is where it has holes, for a table's missing entries."""
    image = Image.open(io.BytesIO(base64.b64decode(encoded)))
    if image.mode != "RGBA" or image.getchannel("A").getextrema() != (255, 255):
        return encoded
    buffer = io.BytesIO()
    image.convert("RGB").quantize(_SHADES, dither=Image.Dither.NONE).save(buffer, "png", optimize=True)
    return base64.b64encode(buffer.getvalue()).decode("ascii")


def shared(svgs: Sequence[str]) -> tuple[list[str], str]:
    """The same elements with their repeated styles as classes, and the style sheet of these: a third less."""
    seen: dict[str, str] = {}

    def named(match: re.Match[str]) -> str:
        return f'class="{seen.setdefault(match[1], f"z{len(seen)}")}"'

    # The first style of each is that of the element itself, its width.
    parts = [re.split(r"(?<=>)", svg, maxsplit=1) for svg in svgs]
    out = [head + re.sub(r'style="([^"]*)"', named, rest) for head, rest in parts]
    return out, "".join(f".{name}{{{style}}}\n" for style, name in seen.items())
