"""How results show themselves in a notebook."""

from __future__ import annotations

import base64
import html
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._core import MapResult

_COLOURS = {"good": "#1a7f37", "doubtful": "#9a6700", "bad": "#cf222e", "unknown": "#57606a"}


def _badge(word: str) -> str:
    return f'<b style="color:{_COLOURS.get(word, "inherit")}">{html.escape(word)}</b>'


def map_result_html(result: MapResult) -> str:
    verdict = result.verdict
    rows = "".join(
        f"<tr><td>{html.escape(m.title)}</td><td>{m.value:.4g}</td><td>{_badge(m.verdict)}</td>"
        f"<td style='text-align:left'>{html.escape(m.sentence)}</td></tr>"
        for m in verdict.measures
    )
    picture = ""
    if result.map is not None:
        data = base64.b64encode(result.to_png()).decode()
        picture = f'<img style="max-width:100%" src="data:image/png;base64,{data}">'
    warnings = "".join(f"<li>{html.escape(text)}</li>" for text in result.warnings)
    return (
        f"<div><p>{_badge(verdict.overall)}: {html.escape(verdict.sentence)}</p>{picture}"
        f"<table>{rows}</table>{f'<ul>{warnings}</ul>' if warnings else ''}</div>"
    )
