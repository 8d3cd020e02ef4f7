"""The tables of docs/published-fits.md: how far every published formula is from what it stands for.

    python benchmarks/published.py --cache .published             # on the screen; --quick: 300 points
    python benchmarks/published.py --cache .published --write     # into the document: 5 CPU minutes

The truth is integrated at random points off any grid, once for all formulas of one contract and domain.
"""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import common
import numpy as np
from choosing import Truth, author, domain_in

import ecfit
from ecfit.approximation import Approximation, lookup_table, published_names
from ecfit.certify.truth import Sampling, measure
from ecfit.contract import Contract
from ecfit.coordinates import resolve
from ecfit.errors import EcfitError
from ecfit.tables.scattered import Scattered

DOCUMENT = Path(__file__).parent.parent / "docs" / "published-fits.md"
HEADER = (
    "formula", "source", "of", "numbers", "MAE", "RMSE", "largest", "at",
    "furnace mean", "99 %", "outside [0, 1]",
)  # fmt: skip
POINTS = 4000
# Fewer where a point is an integral of integrals, or four coordinates.
FEWER = {"average-albedo": 500, "zonal-moment": 500, "multiple-bounces": 500, "brdf": 400}
# Errors below this are those of the integration.
EXACT = 1e-7
# How far outside [0, 1] counts, and at how many points of the closed domain values are looked at.
SLACK, VALUES = 1e-6, 250_000
# Interfaces without absorption are integrated up to ior = 100.
HIGHEST_F0 = 0.96
ALBEDOS = ("directional-albedo", "average-albedo")
TABLES = [
    (count, through)
    for count in (16, 32)
    for through in ({}, {"mu": "square"})
]  # fmt: skip

Points = dict[str, np.ndarray]


@dataclass(frozen=True)
class Group:
    """Formulas of one truth: the same contract, over the same domain.

    Attributes:
        contract: what is integrated; domain: of the sample, r for alpha.
        members: the formulas, in views of their own.
    """

    contract: Contract
    domain: Mapping[str, tuple[float, float]]
    members: list[Approximation]

    def points(self, count: int) -> Points:
        """The sample, in the names of `domain`."""
        first = self.members[0]
        return Sampling(count).points(
            replace(first, variables=tuple(self.domain), domain=tuple(self.domain.values()))
        )


def groups(lookups: bool = True) -> list[Group]:
    """All published formulas, those of one truth together, and look-up tables of the conductor."""
    found: dict[str, Group] = {}
    for name in published_names():
        formula = ecfit.published(name)
        names = sorted("r" if v == "alpha" else v for v in formula.variables)
        domain = domain_in(formula, names)
        if formula.contract.model in ("dielectric", "glossy") and "F0" in domain:
            domain["F0"] = domain["F0"][0], min(domain["F0"][1], HIGHEST_F0)
        contract = replace(formula.contract, sampling="true")
        key = json.dumps([contract.to_dict(), domain], sort_keys=True)
        found.setdefault(key, Group(contract, domain, [])).members.append(formula)
    for group in found.values():
        group.members.sort(key=lambda f: f.count)
        c = group.contract
        if lookups and (c.model, c.quantity) == ("conductor", "directional-albedo") and not c.parameters:
            masking = c.options["masking"]
            for count, through in TABLES:
                model = ecfit.model("conductor", masking=masking)
                group.members.append(lookup_table(model, {"r": count, "mu": count}, through=through))
    return list(found.values())


def section(contract: Contract) -> str:
    """The heading that formulas of a contract go under."""
    if contract.quantity in ("fresnel", "average-fresnel"):
        return "Fresnel factors and their averages"
    if contract.quantity in ("zonal-moment", "multiple-bounces"):
        return "Multiple scattering: zonal moments and saturation"
    if contract.model == "conductor":
        return {
            "directional-albedo": f"Conductor, {contract.options['masking']} masking: E1",
            "schlick-a": "Conductor: the weights A and B of E = F0 A + F90 B",
            "schlick-b": "Conductor: the weights A and B of E = F0 A + F90 B",
            "average-albedo": "Conductor: average albedo",
        }[contract.quantity]
    if contract.model in ("dielectric", "glossy"):
        return "Dielectrics and glossy layers"
    if contract.model.startswith("enterprise"):
        return "A layer with its multiple scattering"
    return "Diffuse reflection and sheen"


SECTIONS = (
    "Conductor, separable masking: E1",
    "Conductor, height-correlated masking: E1",
    "Conductor: average albedo",
    "Conductor: the weights A and B of E = F0 A + F90 B",
    "Dielectrics and glossy layers",
    "A layer with its multiple scattering",
    "Fresnel factors and their averages",
    "Diffuse reflection and sheen",
    "Multiple scattering: zonal moments and saturation",
)


def what(contract: Contract) -> str:
    """The quantity with the conventions that matter."""
    options = contract.options
    quantity = {
        "directional-albedo": "E", "average-albedo": "E_avg", "schlick-a": "A", "schlick-b": "B",
        "average-fresnel": "F_avg", "fresnel": "F", "brdf": "f mu_i", "multiple-bounces": "S",
        "zonal-moment": f"E_{contract.quantity_options.get('degree', 0):g}",
    }[contract.quantity]  # fmt: skip
    bare = contract.quantity in ("fresnel", "average-fresnel")
    model = "a lobe that ecfit has not" if contract.model == "unknown" else contract.model
    words = [f"{quantity} of {model}"]
    words += [] if bare else [options[n] for n in ("masking",) if n in options]
    words += [options[n] for n in ("side",) if n in options]
    fresnel = options.get("fresnel", "unit")
    words += [fresnel] if fresnel not in ("unit", "exact") else []
    words += [f"{n} = {v:g}" for n, v in contract.parameters.items() if n != "F90"]
    words += [contract.transport] if contract.transport != "energy" else []
    return ", ".join(words)


def citation(formula: Approximation) -> str:
    """Author and year of the source, as far as it names them."""
    if formula.form == "lookup":
        return "bilinear"
    person = r"((?:d')?[A-Z]\w+(?: & [A-Z]\w+| et al\.)?)(?:'s factor)?,? \(?((?:19|20)\d\d)\b"
    found = re.search(person, formula.source)
    return f"{found[1]} {found[2]}" if found else author(formula)


def place(at: Mapping[str, float]) -> str:
    """Coordinates in a few digits."""
    return ", ".join(f"{n} {v:.2g}" for n, v in at.items())


def closed(formula: Approximation) -> Points:
    """A grid over the whole closed domain, at most `VALUES` points, denser towards the lower ends.

    F0 ends below 1, where ior is finite.
    """
    count = min(4001, int(VALUES ** (1 / len(formula.variables)) + 1e-9))
    ends = [
        (low, min(high, 0.999) if name == "F0" else high)
        for name, (low, high) in zip(formula.variables, formula.domain, strict=True)
    ]
    grid = np.meshgrid(
        *(low + (high - low) * np.linspace(0.0, 1.0, count) ** 2 for low, high in ends), indexing="ij"
    )
    return {n: g.ravel() for n, g in zip(formula.variables, grid, strict=True)}


def limits(contract: Contract, points: Points) -> tuple[np.ndarray | float, np.ndarray | float] | None:
    """Between which values the quantity lies: 0 and 1 but for what is no albedo; None: of any size."""
    if contract.quantity == "brdf":
        return 0.0, np.inf
    if contract.quantity == "zonal-moment":
        return None
    if contract.transport == "radiance" and contract.options.get("side") == "leaving":
        return 0.0, np.asarray(resolve(("ior",), {"F0": points["F0"]})["ior"]) ** 2
    return 0.0, 1.0


def outside(formula: Approximation) -> str:
    """The least and the greatest value on the closed domain, where they leave the limits."""
    points = closed(formula)
    bounds = limits(formula.contract, points)
    if bounds is None:
        return "-"
    with np.errstate(all="ignore"):
        value = np.asarray(formula.formula.value([points[n] for n in formula.variables]))
    value = np.broadcast_to(value, next(iter(points.values())).shape)
    low, high = bounds
    found = []
    broken = ~np.isfinite(value)
    if broken.any():
        i = int(np.argmax(broken))
        found.append(f"not finite at {place({n: float(p[i]) for n, p in points.items()})}")
    # How far below and above.
    for sign, limit in ((-1.0, low), (1.0, high)):
        excess = np.where(broken, -np.inf, sign * (value - limit))
        i = int(np.argmax(excess))
        if excess[i] > SLACK:
            note = f" (limit {limit[i]:.3g})" if isinstance(limit, np.ndarray) else ""
            near = not note and limit == 1.0 and excess[i] < 0.005
            shown = f"1 + {excess[i]:.0e}" if near else f"{value[i]:.3g}"
            found.append(f"{shown}{note} at {place({n: float(p[i]) for n, p in points.items()})}")
    least = formula.smallest_denominator()
    if least.value <= 0.0:
        where = dict(zip(formula.variables, least.place, strict=True))
        found.append(f"pole: Q = {least.value:.2g} at {place(where)}")
    return "; ".join(found) or "no"


def number(error: float) -> str:
    """An error, or that it is none."""
    return f"{error:.1e}" if error >= EXACT else "exact"


def percent(deviation: float) -> str:
    """A furnace's deviation."""
    if deviation >= 1.0:
        return "over 100%"
    return f"{deviation:.2%}"


def row(formula: Approximation, points: Points, truth: Scattered | str) -> tuple[str, ...]:
    """One line of the table."""
    name = f"`{formula.name}`"
    head = (name, citation(formula), what(formula.contract), str(formula.count))
    none = ("-",) * 6
    if isinstance(truth, str):
        return (*head, *none, f"no truth: {truth}")
    at = {n: np.asarray(v) for n, v in resolve(formula.variables, points).items()}
    own = {n: at[n] for n in formula.variables}
    errors = measure(formula, own, truth)
    if errors is None:
        return (*head, *none, "no truth: no integral of the sample converges")
    furnace = ("-", "-")
    if formula.contract.quantity in ALBEDOS:
        exact = errors.furnace_max < EXACT
        furnace = tuple("exact" if exact else percent(v) for v in (errors.furnace_mean, errors.furnace_p99))
    return (
        *head, number(errors.mae), number(errors.rmse), number(errors.max_error),
        place(errors.place) if errors.max_error >= EXACT else "-", *furnace, outside(formula),
    )  # fmt: skip


def integrals(truths: Truth, contract: Contract, points: Points) -> Scattered:
    """The truth at points; a coordinate that the contract fixes is one of them."""
    fixed = {n: v for n, v in contract.parameters.items() if n == "mu"}
    rest = {n: v for n, v in contract.parameters.items() if n not in fixed}
    count = next(iter(points.values())).size
    given = points | {n: np.full(count, v) for n, v in fixed.items()}
    return truths.at(replace(contract, parameters=rest), given)


def tables(truths: Truth, count: int) -> dict[str, str]:
    """Section -> its table in Markdown."""
    rows: dict[str, list[tuple[str, ...]]] = {name: [] for name in SECTIONS}
    for group in groups():
        contract = group.contract
        points = group.points(min(count, FEWER.get(contract.quantity, count)))
        truth: Scattered | str
        try:
            truth = integrals(truths, contract, points)
            print(f"  {what(contract)}", flush=True)
        except EcfitError as error:
            truth = str(error)
            print(f"  {what(contract)}: {error}", flush=True)
        rows[section(contract)] += [row(f, points, truth) for f in group.members]
    return {name: common.markdown(HEADER, found) for name, found in rows.items() if found}


def document(found: Mapping[str, str], names: Sequence[str] = SECTIONS) -> str:
    """The sections in their order."""
    return "\n\n".join(f"### {name}\n\n{found[name]}" for name in names if name in found)


def main() -> None:
    """Print or write."""
    parser = common.arguments(__doc__)
    parser.add_argument("--write", action="store_true", help="write docs/published-fits.md")
    parser.add_argument("--cache", type=Path, help="folder that keeps integrals")
    given = parser.parse_args()
    text = document(tables(Truth(given.cache), 300 if given.quick else POINTS))
    if given.write:
        common.replace_between(DOCUMENT, "published.py", formulas=text)
    print(text)


if __name__ == "__main__":
    main()
