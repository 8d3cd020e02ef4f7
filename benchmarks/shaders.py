"""Exported code on this machine's compilers and devices: what compiles, what runs, how near to NumPy.

    python benchmarks/shaders.py                  # all tools that are here; two minutes of one processor
    python benchmarks/shaders.py --quick          # few points
    python benchmarks/shaders.py --write          # puts the table of tools into docs/export.md
    python benchmarks/shaders.py --tool webgpu    # only one; repeatable

All shipped fits, and for two tools (in C and in WGSL) all published formulas of up to four coordinates too,
exported with the defaults to each language, one program a tool. Points lie in the closed domain of each: half
of them on corners, edges and near them, half uniform. Install what is missing with `make system` and `make
shaders`, or `pip install 'ecfit[shaders]'` and `pip install --no-deps slangtorch`; for OSL set
ECFIT_BPY_PYTHON to a Python with Blender's bpy.
"""

import common
import numpy as np

import ecfit
from ecfit.approximation import Approximation, find, published_names
from ecfit.errors import EcfitError
from ecfit.export.code import default_name, expression
from ecfit.export.coordinates import arguments
from ecfit.expressions import cost
from ecfit.shaders import TOOLS, Tool, case, check_all
from ecfit.shaders.agreement import AGAIN, COMMON, ULP, Agreement
from ecfit.shaders.cases import LEAST
from ecfit.shaders.check import Report
from ecfit.shaders.tools import tool as named

POINTS, QUICK = 2048, 2 * LEAST
# Whose values stand for exported code on the processor, and on a device, in the table of fits.
PROCESSOR, DEVICE = "cc", "webgpu"


def published() -> list[Approximation]:
    """Published formulas that a program can call."""
    found = []
    for name in published_names():
        try:
            case(find(name), "c")
        except EcfitError:  # a table
            continue
        found.append(find(name))
    return found


def row(report: Report) -> list[str]:
    """One tool."""
    tool = report.tool
    start = [f"`{tool.name}`", tool.language, tool.shows]
    if report.outcome is None:
        return [*start, report.done, "", "", ""]
    agreements = report.outcome.agreements
    versions = ", ".join(x for x in (tool.versions(), report.outcome.device) if x)
    if not agreements:
        return [*start, report.done, versions, "", ""]
    names = {default_name(ecfit.shipped(n)) for n in ecfit.shipped()}
    shipped = [a for a in agreements if a.name in names]
    worst = max(shipped, key=lambda a: a.worst)
    error = max(a.error for a in shipped)
    number = f"{worst.worst:.3g} ({worst.name})" if worst.worst else "0"
    return [*start, report.done if report.passes else "failed", versions, number, f"{error:.1e}"]


def tools(reports: list[Report]) -> str:
    """A row a tool."""
    header = ["tool", "language", "what success shows", "here", "versions", "worst ulps", "error"]
    return common.markdown(header, [row(r) for r in reports])


def fits(found: list[Approximation], reports: list[Report]) -> str:
    """A row a formula: on the processor, where every operation rounds as written, and on a device."""
    outcomes = {r.tool.name: r.outcome.agreements for r in reports if r.outcome is not None}
    on_processor, on_device = outcomes.get(PROCESSOR, ()), outcomes.get(DEVICE, ())
    common_part = f"{COMMON:g} %"
    header = ["name", "operations", common_part, "worst", "error", "device: " + common_part, "worst", "error"]
    rows = []
    for i, approximation in enumerate(found):
        operations = str(cost(expression(approximation, arguments(approximation, (), False))))
        cells = [*_cells(on_processor, i), *_cells(on_device, i)]
        rows.append([approximation.name, operations, *cells])
    return common.markdown(header, rows)


def _cells(agreements: tuple[Agreement, ...], i: int) -> list[str]:
    if not agreements:
        return ["", "", ""]
    a = agreements[i]
    return [f"{a.exact_common:.1f}", f"{a.exact_worst:.3g}", f"{a.error:.1e}"]


def main() -> None:
    parser = common.arguments(__doc__)
    parser.add_argument("--write", action="store_true", help="put the table of tools into docs/export.md")
    parser.add_argument("--tool", action="append", help="only this tool; repeatable")
    given = parser.parse_args()
    chosen: list[Tool] = [named(t) for t in given.tool] if given.tool else list(TOOLS.values())
    ours = [ecfit.shipped(name) for name in ecfit.shipped()]
    found = [*ours, *published()]
    points = QUICK if given.quick else POINTS
    both = [t for t in chosen if t.name in (PROCESSOR, DEVICE)]
    reports = []
    for formulas, some in ((found, both), (ours, [t for t in chosen if t not in both])):
        for report in check_all(formulas, some, points):
            print(report.describe(), flush=True)
            reports.append(report)
    reports.sort(key=lambda r: list(TOOLS).index(r.tool.name))
    print(f"\n{tools(reports)}\n\n{fits(found, reports)}")
    values = [a for r in reports if r.outcome is not None for a in r.outcome.agreements]
    bad = sum(a.not_finite + a.unknown for a in values)
    ratio = max((a.error / (AGAIN * a.numpy_error + ULP) for a in values), default=np.nan)
    print(f"\n{len(values)} functions run, {bad} values not finite, worst error / allowed: {ratio:.2f}")
    if given.write:
        common.replace_between(common.DOCS / "export.md", "shaders.py", tools=tools(reports))


if __name__ == "__main__":
    main()
