"""The comment of an exported file: what its numbers mean, and how good they are."""

import hashlib
import json
import textwrap
from collections.abc import Sequence

from ecfit.approximation import Approximation
from ecfit.approximation.approximation import OURS
from ecfit.contract import LOBES, QUANTITIES, TRANSPORTS
from ecfit.export.coordinates import MEANINGS, Arguments
from ecfit.expressions.cost import Cost

_WIDTH = 100
_LABEL = 11


def fingerprint(approximation: Approximation) -> str:
    """Hash of everything that determines the approximation but its name: 16 hexadecimal digits."""
    data = {k: v for k, v in approximation.to_dict().items() if k != "name"}
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]


def contract_lines(
    approximation: Approximation,
    function: str,
    arguments: Arguments,
    clamped: bool,
    cost: Cost | None,
    evidence: Sequence[str],
) -> list[str]:
    """Lines of the comment, without what comments start with.

    Args:
        function: its name in the file.
        arguments: what it takes.
        clamped: whether it clamps them.
        cost: operations of the exported expression; None for a table.
        evidence: what is known of its errors.
    """
    contract = approximation.contract
    model = ", ".join([contract.model, *(f"{k} = {v}" for k, v in contract.options.items())])
    settings = {**contract.parameters, **contract.quantity_options}
    rows = [("Value", f"{contract.quantity}: {QUANTITIES[contract.quantity]}")]
    rows.append(("Model", model))
    rows += [("", f"{k} = {v:g}") for k, v in settings.items()]
    rows.append(("Lobe", f"{contract.lobe} ({LOBES[contract.lobe]})"))
    rows.append(("Transport", f"{contract.transport} ({TRANSPORTS[contract.transport]})"))
    if contract.sampling == "clamped":
        rows.append(
            ("Sampling", "the table's nodes were clamped: coordinates at the ends are not the true ones")
        )
    label = "Arguments"
    for name, (low, high) in zip(arguments.names, arguments.domain, strict=True):
        rows.append((label, f"{name} in [{low:.6g}, {high:.6g}]: {MEANINGS.get(name, name)}"))
        label = ""
    outside = (
        "clamped to these ranges" if clamped else "not clamped: what lies outside is the caller's to clamp"
    )
    rows.append(("", outside))
    rows += [("Error", text) if i == 0 else ("", text) for i, text in enumerate(evidence)]
    numbers = f"{approximation.count} numbers"
    rows.append(("Cost", f"{numbers}, {cost}" if cost is not None else numbers))
    ours = approximation.source == OURS
    rows.append(("Origin", f"ecfit, fit '{approximation.name}'" if ours else approximation.source))
    rows.append(("Hash", fingerprint(approximation)))
    lines = [f"{function}({', '.join(arguments.names)})", ""]
    for label, text in rows:
        parts = textwrap.wrap(text, _WIDTH - 4 - _LABEL, break_long_words=False, break_on_hyphens=False)
        lines += [f"{label if i == 0 else '':<{_LABEL}}{part}" for i, part in enumerate(parts)]
    lines.append("")
    if not ours:
        lines.append("The coefficients are their authors'; this code around them may be pasted anywhere:")
    lines.append("SPDX-License-Identifier: MIT-0")
    return lines
