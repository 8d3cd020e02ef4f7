"""The tables of docs/shipped-fits.md: what the certificates of the shipped fits say, and thin layers.

    python benchmarks/shipped.py             # on the screen; --quick: with few points in the thin layers
    python benchmarks/shipped.py --write     # into the document

Everything but the thin layers is read from the files that `ecfit ship` wrote: nothing is measured again.
"""

from pathlib import Path

import common
import numpy as np

import ecfit
from ecfit.approximation import Approximation
from ecfit.approximation.shipped import shipped_folder
from ecfit.certify import Certificate
from ecfit.certify.truth import LOOSE, Sampling
from ecfit.files import read_json
from ecfit.tables.scattered import integrate

DOCUMENT = Path(__file__).parent.parent / "docs" / "shipped-fits.md"
HEADER = (
    "fit", "numbers", "domain", "MAE", "RMSE", "largest", "furnace 99 %", "values",
    "towards the corner: MAE, largest", "float32",
)  # fmt: skip
# Beyond the domains of the fits, towards no interface at all: sqrt(F0) in these ranges.
THIN = {
    "glossy": [("F0 in [1e-4, 1e-2]", (1e-2, 1e-1)), ("F0 in [1e-6, 1e-4]", (1e-3, 1e-2))],
    "dielectric": [
        ("ior in [1.01, 1.05]", (0.01 / 2.01, 0.05 / 2.05)), ("ior in [1.001, 1.01]", (0.0005, 0.01 / 2.01)),
    ],
}  # fmt: skip


def certificates() -> dict[str, tuple[Approximation, Certificate]]:
    """Every shipped fit with its certificate."""
    out = {}
    for name in ecfit.shipped():
        data = read_json(shipped_folder() / f"{name}.json")
        out[name] = ecfit.shipped(name), Certificate.from_dict(data["certificate"])
    return out


def _group(approximation: Approximation) -> str:
    contract = approximation.contract
    options = [str(v) for k, v in contract.options.items() if k in ("masking", "side", "ndf") and v != "ggx"]
    return ", ".join([contract.model, *options, contract.quantity.replace("directional-albedo", "")]).strip(
        ", "
    )


def table() -> str:
    """One row a fit."""
    rows = []
    found = sorted(certificates().items(), key=lambda e: (_group(e[1][0]), e[1][0].count))
    for name, (approximation, certificate) in found:
        domain = ", ".join(
            f"{k} {low:.4g}..{high:.4g}"
            for k, (low, high) in certificate.domain.items()
            if k not in ("mu", "alpha")
        )
        errors, near, values = certificate.errors, certificate.corner_errors, certificate.values
        assert errors is not None
        assert values is not None
        rows.append(
            (
                f"`{name}`", str(approximation.count), domain or "all", f"{errors.mae:.2e}",
                f"{errors.rmse:.2e}",
                f"{errors.max_error:.2e}",
                f"{errors.furnace_p99:.2%}" if errors.furnace_p99 < 0.1 else "-",
                f"[{values.low:.3g}, {values.high:.3g}]",
                f"{near.mae:.1e}, {near.max_error:.1e}" if near is not None else "-",
                f"{max(certificate.single.largest, certificate.single_hard.largest):.1e}",
            )
        )  # fmt: skip
    return common.markdown(HEADER, rows)


def thin(count: int) -> str:
    """Errors of fits below their domain, where there is hardly an interface."""
    rows = []
    truths: dict[str, np.ndarray] = {}
    for name, (approximation, _) in certificates().items():
        if "F0" not in approximation.variables:
            continue
        for label, ends in THIN.get(approximation.contract.model, []):
            index = approximation.variables.index("F0")
            domain = list(approximation.domain)
            if ends[1] ** 2 > domain[index][0] * 1.000001:
                continue
            domain[index] = ends[0] ** 2, ends[1] ** 2
            wide = Approximation(
                name, approximation.form, approximation.degree, approximation.variables,
                approximation.formula, tuple(domain), approximation.contract,
            )  # fmt: skip
            points = Sampling(count, 1).points(wide)
            key = f"{approximation.contract.to_dict()} {label} {sorted(points)}"
            if key not in truths:
                found = integrate(approximation.contract, points, 1e-7)
                truths[key] = np.where(found.errors <= LOOSE, found.values, np.nan)
            value = np.asarray(wide.formula.value([points[v] for v in wide.variables]))
            good = np.isfinite(truths[key])
            error = np.abs(value - truths[key])[good]
            with np.errstate(divide="ignore"):
                furnace = np.abs(truths[key] / value - 1.0)[good]
            rows.append(
                (
                    f"`{name}`", label, f"{error.mean():.2e}", f"{error.max():.2e}",
                    f"{np.quantile(furnace, 0.99):.1%}",
                )
            )  # fmt: skip
    return common.markdown(("fit", "beyond its domain", "MAE", "largest", "furnace 99 %"), rows)


def main() -> None:
    """Print or write."""
    parser = common.arguments(__doc__)
    parser.add_argument("--write", action="store_true", help="write docs/shipped-fits.md")
    given = parser.parse_args()
    fits, layers = table(), thin(100 if given.quick else 1000)
    if given.write:
        common.replace_between(DOCUMENT, "shipped.py", **{"fits": fits, "thin layers": layers})
    print(fits, layers, sep="\n\n")


if __name__ == "__main__":
    main()
