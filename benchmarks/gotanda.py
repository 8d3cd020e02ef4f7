"""The measurements and figures of docs/systems/gotanda.md (Gotanda 2014).

    ecfit run configs/gotanda.toml                    # the fits
    python benchmarks/gotanda.py --write              # two minutes: tables into the page, figures beside it
    python benchmarks/gotanda.py --quick              # a look, on the screen

Errors of the diffuse lobe are of f mu_i for F0 = 0, at random points: alpha and the azimuth uniform, mu and
mu_i uniform in [0.01, 1] or, "grazing", within [0.01, 0.1]. The integral is good to 1e-6 there.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

import common
import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import linprog

import ecfit
from ecfit._jax import jax, jnp
from ecfit.approximation import Approximation
from ecfit.approximation.published import find
from ecfit.bsdf.microfacet_diffuse import schlick_pair
from ecfit.coordinates import Axis
from ecfit.expressions import cost
from ecfit.forms.written import WrittenForm
from ecfit.microfacet import NDFS
from ecfit.quadrature import Estimate, FacetPairs
from ecfit.report.style import look, rendered
from ecfit.tables.scattered import integrate

Array = np.ndarray
Points = dict[str, Array]

PAGE = common.DOCS / "systems" / "gotanda.md"
FITS = Path("results/gotanda/fits")
TRUTH, PRINTED, REFITTED, OURS = "integral", "eq. 8, printed", "eq. 8, refitted", "reciprocal-13"
COLOURS = {TRUTH: "black", PRINTED: "#0072B2", REFITTED: "#56B4E9", OURS: "#D55E00"}
ALUMINIUM = (1.3, 7.48)

# Readings of eq. 8: what is replaced in its definitions.
READINGS: dict[str, tuple[tuple[str, str], ...]] = {
    "kept": (),
    "V_d's factor twice": (("vd", "a2/((a2 + 0.09)*(1.31072 + 0.995584*mu)) * w * w"),),
    "V_d's factor left out": (("vd", "a2/((a2 + 0.09)*(1.31072 + 0.995584*mu))"),),
    "n.e in place of (n.e)^2 in V_d": (("w", "1 - exp((1 - 0.3726732*mu)/(0.188566 + 0.38841*mu)*v)"),),
    "F_r's second factor 1 - (1 - n.e)^(5 - 4 sigma^2)": (("fr2", "1 - exp((5 - 4*a2)*u)"),),
    "L_m (1 - sigma/2 (n.l - 1)) n.l, as in shader ports": (("lm2", "mu_i*(1 - 0.5*alpha*(mu_i - 1))"),),
    "the same and V_d + B_p, as in most shader ports": (
        ("lm2", "mu_i*(1 - 0.5*alpha*(mu_i - 1))"),
        ("total", "fr*lm1*lm2 + vd + bp"),
    ),
}
_EQ8 = {
    "a2": "alpha*alpha",
    "q": "a2 + 1.36053",
    "u": "log(max(1 - mu, 1e-12))",
    "v": "log(max(1 - mu_i, 1e-12))",
    "fr1": "1 - (0.542026*a2 + 0.303573*alpha)/q",
    "fr2": "1 - exp((5 - 4*a2)*u)/q",
    "fr3": "1 + alpha*(-1.16402 + alpha*(1.50912 - 0.733996*alpha))*exp((1 + 1/(39*a2*a2 + 1))*u)",
    "fr": "fr1*fr2*fr3",
    "lm1": "max(1 - 2*alpha, 0)*(1 - (1 - mu_i)**5) + min(2*alpha, 1)",
    "lm2": "mu_i*(1 - 0.5*alpha + 0.5*alpha*mu_i)",
    "w": "1 - exp((1 - 0.3726732*mu*mu)/(0.188566 + 0.38841*mu)*v)",
    "vd": "a2/((a2 + 0.09)*(1.31072 + 0.995584*mu)) * w",
    "s": "cos_phi*sqrt(max((1 - mu*mu)*(1 - mu_i*mu_i), 0))",
    "bp": "max(s, 0) + 1.4*mu*mu_i*min(s, 0)",
    "total": "fr*lm1*lm2 + vd*bp",
}


def reading(changes: tuple[tuple[str, str], ...]) -> Approximation:
    """Eq. 8 with some of its definitions read otherwise."""
    printed = ecfit.published("gotanda-2014-diffuse").to_dict()
    lets = [[n, t] for n, t in (_EQ8 | dict(changes)).items()]
    return Approximation.from_dict({**printed, "let": lets, "formula": "0.33422538049298023*total"})


def points(count: int, seed: int, high: float = 1.0) -> Points:
    """Random points of the domain."""
    rng = np.random.default_rng(seed)
    mu, mu_i = rng.uniform(0.01, high, (2, count))
    cos_phi = np.cos(rng.uniform(0.0, np.pi, count))
    return {"alpha": rng.uniform(0.0, 1.0, count), "mu": mu, "mu_i": mu_i, "cos_phi": cos_phi}


def swapped(p: Points) -> Points:
    """Light and view exchanged."""
    return {**p, "mu": p["mu_i"], "mu_i": p["mu"]}


def truth(p: Points) -> Array:
    """f mu_i by integration."""
    found = integrate(ecfit.published("gotanda-2014-diffuse").contract, p, 1e-6)
    assert found.errors.max() < 2e-6
    return found.values


def number(x: float) -> str:
    """Three digits."""
    return f"{x:.2e}" if abs(x) < 0.01 else f"{x:.3g}"


def errors(found: Array, wanted: Array, p: Mapping[str, Array]) -> list[str]:
    """MAE, RMSE, largest error and its place, as cells."""
    e = np.abs(found - wanted)
    i = int(np.argmax(e))
    place = ", ".join(f"{n} {v[i]:.2f}" for n, v in p.items())
    return [number(float(e.mean())), number(float(np.sqrt((e * e).mean()))), number(float(e.max())), place]


def readings(p: Points, wanted: Array) -> str:
    """Every reading's errors."""
    rows = []
    for name, changes in READINGS.items():
        rows.append([name, *errors(np.asarray(reading(changes)(**p)), wanted, p)[:3]])
    kept = reading(())
    squared = truth({**p, "alpha": p["alpha"] ** 2})
    rows.insert(1, ["alpha = sigma^2 in place of sigma", *errors(np.asarray(kept(**p)), squared, p)[:3]])
    exchanged = np.asarray(kept(**swapped(p))) * p["mu_i"] / p["mu"]
    rows.append(["light and view exchanged", *errors(exchanged, wanted, p)[:3]])
    rows.append(["L_r = f, without the cosine", *errors(np.asarray(kept(**p)) * p["mu_i"], wanted, p)[:3]])
    return common.markdown(["reading", "MAE", "RMSE", "largest"], rows)


def lobes() -> dict[str, Approximation]:
    """What is compared: the printed fit and those of the study."""
    return {
        PRINTED: ecfit.published("gotanda-2014-diffuse"),
        REFITTED: find(str(FITS / "eq8-refitted.json")),
        OURS: find(str(FITS / "reciprocal-13.json")),
    }


def accuracy(p: Points, wanted: Array, grazing: Points, wanted_grazing: Array) -> str:
    """Errors, costs, range and reciprocity of every lobe."""
    rows = []
    for name, made in lobes().items():
        f = np.asarray(made(**p)) / p["mu_i"]
        other = np.asarray(made(**swapped(p))) / p["mu"]
        e = np.abs(np.asarray(made(**grazing)) - wanted_grazing)
        low = float(np.asarray(made(**points(200_000, 9))).min())
        what = cost(made.expression())
        rows.append(
            [
                name, str(made.count), *errors(f * p["mu_i"], wanted, p),
                f"{number(float(e.mean()))} / {number(float(e.max()))}",
                number(float(np.abs(f - other).max())), number(low), f"{what} ({what.total:g})",
            ]
        )  # fmt: skip
    header = ["f mu_i", "numbers", "MAE", "RMSE", "largest", "at", "grazing, mean / largest"]
    return common.markdown(
        [*header, "f against f exchanged, largest", "least value", "operations (total)"], rows
    )


def albedo(value: Callable[[Points], Array], alpha: Array, mu: Array) -> Array:
    """The integral of f mu_i over the hemisphere, shape (alpha, mu), by 32 x 16 Gauss nodes."""
    x, w = (np.polynomial.legendre.leggauss(n) for n in (32, 16))
    t, wt = 0.5 * (x[0] + 1.0), 0.5 * x[1]
    phi, wp = 0.5 * np.pi * (w[0] + 1.0), np.pi * w[1]  # both halves of the circle
    axes = np.meshgrid(alpha, mu, t**3, np.cos(phi), indexing="ij")
    p: Points = dict(zip(("alpha", "mu", "mu_i", "cos_phi"), (a.ravel() for a in axes), strict=True))
    values = value(p).reshape(axes[0].shape)
    return np.einsum("abij,i,j->ab", values, wt * 3.0 * t * t, wp)


def energy(quick: bool) -> str:
    """Directional albedos of diffuse and specular light together, F0 = 0.04."""
    f0, alpha = 0.04, np.linspace(0.0, 1.0, 6 if quick else 11)
    mu = np.array([0.02, 0.05, 0.1, 0.2, 0.5, 1.0])
    specular = ecfit.model("conductor", fresnel="schlick", F0=f0, masking="height-correlated")
    axes = {"alpha": Axis.given("alpha", alpha), "mu": Axis.given("mu", mu)}
    layer = ecfit.tabulate(specular, axes, tolerance=1e-7).values
    diffuse = ecfit.tabulate(ecfit.model("microfacet-diffuse", F0=f0), axes, tolerance=2e-4)
    assert diffuse.errors.max() < 1e-3
    rows = []
    found = {TRUTH: diffuse.values}
    for name, made in lobes().items():
        found[name] = (1.0 - f0) * albedo(lambda p, made=made: np.asarray(made(**p)), alpha, mu)
    for name, e in found.items():
        total = e + layer
        i, j = np.unravel_index(int(np.argmax(total)), total.shape)
        off = np.abs(e - diffuse.values)
        rows.append(
            [
                name, f"{total[i, j]:.4f}", f"alpha {alpha[i]:.1f}, mu {mu[j]:.2f}", f"{total.min():.3f}",
                *(f"{total[np.isclose(alpha, a), -1][0]:.3f}" for a in (0.0, 0.2, 1.0)),
                f"{number(float(off.mean()))} / {number(float(off.max()))}",
            ]
        )  # fmt: skip
    header = ["diffuse + specular", "largest", "at", "least", "mu 1, alpha 0", "alpha 0.2", "alpha 1"]
    return common.markdown([*header, "error of the diffuse part, mean / largest"], rows)


def fresnel() -> str:
    """Eq. 2, eq. 3, Schlick and ours against exact Fresnel of dielectrics and aluminium."""
    mu = np.linspace(0.0, 1.0, 401)
    eta, k = ALUMINIUM
    metal = ecfit.model("conductor", fresnel="exact", eta=eta, k=k)
    aluminium = ecfit.tabulate(metal, {"mu": mu}, quantity="fresnel").values
    f0s = [0.02, 0.04, 0.06, 0.1, 0.2, 0.3, 0.5, 0.8]
    truths = {f"F0 {f0:g}": (f0, _dielectric(f0, mu)) for f0 in f0s}
    truths[f"aluminium, F0 {aluminium[-1]:.3f}"] = (float(aluminium[-1]), aluminium)
    made: dict[str, Callable[[float, Array], Array]] = {
        "Schlick": _named("schlick-fresnel"),
        "eq. 2": _named("gotanda-2014-fresnel-reflectance"),
        "eq. 3, printed": _named("gotanda-2014-fresnel"),
        "eq. 3, refitted at 1.5": _shape(find(str(FITS / "eq3-refitted.json"))),
        "squared-ratio-2": _shape(find(str(FITS / "squared-ratio-2.json"))),
        "squared-ratio-dielectrics-5": lambda f0, x: np.asarray(
            find(str(FITS / "squared-ratio-dielectrics-5.json"))(F0=np.full_like(x, f0), mu=x)
        ),
    }
    rows = []
    for what, (f0, wanted) in truths.items():
        cells = []
        for value in made.values():
            e = np.abs(value(f0, mu) - wanted)
            cells.append(f"{number(float(e.mean()))} / {number(float(e.max()))}")
        rows.append([what, *cells])
    return common.markdown(["mean / largest error", *made], rows)


def validity() -> str:
    """Ranges of F0 in which eq. 3 is better than Schlick's factor, and what cos^2 in it would give."""
    mu = np.linspace(0.0, 1.0, 401)
    grid = np.linspace(0.005, 0.95, 946)
    lines = []
    names = {"eq. 3": "gotanda-2014-fresnel", "Schlick's": "schlick-fresnel"}
    worst = {n: np.array([np.abs(_named(f)(x, mu) - _dielectric(x, mu)).max() for x in grid])
             for n, f in names.items()}  # fmt: skip
    for factor, text in ((1.0, "100 %"), (1 / 1.1, "91 %"), (0.5, "half"), (0.25, "a quarter")):
        where = _interval(grid, worst["eq. 3"] < factor * worst["Schlick's"])
        lines.append(f"eq. 3's largest error is below {text} of Schlick's for {where}")
    for limit in (0.01, 0.02, 0.05):
        for name, e in worst.items():
            lines.append(f"{name.removesuffix(chr(39) + 's')}: largest error below {limit:g} for "
                         f"{_interval(grid, e < limit)}")  # fmt: skip
    glass = ecfit.tabulate(ecfit.model("dielectric", ior=1.5), {"mu": mu}, quantity="fresnel")
    for power in (2, 4, 6, 8, 10):
        formula, start = f"0.04 + 0.96*exp2(k1*mu**{power} + k2*mu)", {"k1": -1.0, "k2": -8.0}
        fit = ecfit.fit(glass, WrittenForm(formula, start, ["mu"]))
        off = np.abs(0.04 + 0.96 * 2.0 ** (-9.60232 * mu**power - 8.58092 * mu) - glass.values)
        lines.append(
            f"cos^{power} in eq. 3 at 1.5: printed numbers {number(float(off.mean()))} / "
            f"{number(float(off.max()))}, refitted {number(fit.mae)} / {number(fit.max_error)}"
        )
    return "\n".join(f"- {line}" for line in lines)


def _interval(grid: Array, inside: Array) -> str:
    """Where a condition holds on a grid of F0, in intervals."""
    steps = np.diff(np.concatenate([[0], inside.astype(int), [0]]))
    ends = zip(np.flatnonzero(steps == 1), np.flatnonzero(steps == -1) - 1, strict=True)
    found = [f"[{grid[a]:.3f}, {grid[b]:.3f}]" for a, b in ends]
    return "F0 in " + " and ".join(found) if found else "no F0"


def convergence(count: int) -> str:
    """The rule's levels against its finest one: a third each grazing, smooth, and spread evenly."""
    rng = np.random.default_rng(3)
    p = rng.random((4, count))
    third = count // 3
    p[0, :third] = 10.0 ** rng.uniform(-3, 0, third)
    p[1, third // 2 : 2 * third] = 10.0 ** rng.uniform(-4, -1, 2 * third - third // 2)
    p[2, third : 2 * third] = 10.0 ** rng.uniform(-4, -1, third)
    p[3] = np.cos(np.pi * p[3])
    ndf, weight = NDFS["ggx"], schlick_pair
    levels = range(len(FacetPairs.ORDERS))

    def at(level: int) -> Estimate:
        def one(x: jax.Array) -> Estimate:
            return FacetPairs(ndf, x[0], weight).integral(x[1], x[2], x[3], level)

        return jax.lax.map(one, jnp.asarray(p.T), batch_size=20)

    found = [jax.tree.map(np.asarray, jax.jit(at, static_argnums=0)(level)) for level in levels]
    rows = []
    for (slope, azimuth), (value, estimate) in zip(FacetPairs.ORDERS[:-1], found[:-1], strict=True):
        e = np.abs(value - found[-1].value)
        cells = [number(float(e.mean())), number(float(e.max()))]
        rows.append([f"{slope} x {12 * azimuth}", *cells, f"{np.max(e / np.maximum(estimate, 1e-13)):.2f}"])
    header = ["nodes, slope x azimuth", "mean error", "largest", "error / estimate, largest"]
    return common.markdown(header, rows)


def _dielectric(f0: float, mu: Array) -> Array:
    n = (1.0 + f0**0.5) / (1.0 - f0**0.5)
    return ecfit.tabulate(ecfit.model("dielectric", ior=n), {"mu": mu}, quantity="fresnel").values


def _named(name: str) -> Callable[[float, Array], Array]:
    made = ecfit.published(name)
    return lambda f0, mu: np.asarray(made(F0=np.full_like(mu, f0), mu=mu))


def _shape(made: Approximation) -> Callable[[float, Array], Array]:
    """A fit at ior 1.5 as a shape between F0 and 1."""
    return lambda f0, mu: f0 + (1.0 - f0) * (np.asarray(made(mu=mu)) - 0.04) / 0.96


def curves() -> Figure:
    """f mu_i pi against theta_i in the plane of wo and across it, as figures 11 to 15 of the source."""
    theta = np.linspace(-89.0, 89.0, 121)
    settings = [(0.1, 0.0, 0.0), (0.3, 45.0, 0.0), (0.8, 45.0, 0.0), (0.3, 80.0, 0.0), (0.8, 80.0, 0.0),
                (0.8, 80.0, 45.0)]  # fmt: skip
    with look():
        figure = Figure(figsize=(9.6, 5.2), layout="constrained")
        panels = figure.subplots(2, 3, sharey=True).ravel()
        for axes, (alpha, view, turn) in zip(panels, settings, strict=True):
            side = np.where(theta >= 0.0, 1.0, -1.0)
            p = {
                "alpha": np.full_like(theta, alpha),
                "mu": np.full_like(theta, np.cos(np.radians(view))),
                "mu_i": np.cos(np.radians(theta)),
                "cos_phi": side * np.cos(np.radians(turn)),
            }
            axes.plot(theta, np.pi * truth(p), color=COLOURS[TRUTH], label=TRUTH, linewidth=2.0)
            for name, made in lobes().items():
                axes.plot(theta, np.pi * np.asarray(made(**p)), "--", color=COLOURS[name], label=name)
            out = f", {turn:g} deg out of plane" if turn else ""
            axes.set_title(f"sigma = {alpha:g}, view at {view:g} deg{out}", fontsize=8)
            axes.grid(True, alpha=0.3)
        for axes in panels[3:]:
            axes.set_xlabel("angle of light, degrees (positive: the viewer's side)")
        panels[0].set_ylabel("pi f mu_i")
        panels[3].set_ylabel("pi f mu_i")
        panels[0].legend(frameon=False, fontsize=7)
    return figure


def fresnel_curves() -> Figure:
    """Errors at ior 1.5, and the curves for aluminium."""
    mu = np.linspace(0.0, 1.0, 401)
    degrees = np.degrees(np.arccos(mu))
    exact = _dielectric(0.04, mu)
    metal = ecfit.model("conductor", fresnel="exact", eta=ALUMINIUM[0], k=ALUMINIUM[1])
    aluminium = ecfit.tabulate(metal, {"mu": mu}, quantity="fresnel").values
    f0 = float(aluminium[-1])
    made = {
        "Schlick": _named("schlick-fresnel"),
        "eq. 3, printed": _named("gotanda-2014-fresnel"),
        "eq. 3, refitted": _shape(find(str(FITS / "eq3-refitted.json"))),
        "squared-ratio-2": _shape(find(str(FITS / "squared-ratio-2.json"))),
    }
    with look():
        figure = Figure(figsize=(9.6, 3.4), layout="constrained")
        left, right = figure.subplots(1, 2)
        for name, value in made.items():
            left.plot(degrees, value(0.04, mu) - exact, label=name)
        left.set(xlabel="angle, degrees", ylabel="error", title="ior = 1.5")
        right.plot(degrees, aluminium, color="black", linewidth=2.0, label="exact, 1.3 + 7.48 i")
        for name in ("Schlick", "eq. 3, printed"):
            right.plot(degrees, made[name](f0, mu), "--", label=name)
        right.plot(degrees, _named("gotanda-2014-fresnel-reflectance")(f0, mu), ":", label="eq. 2")
        right.set(xlabel="angle, degrees", title="aluminium")
        for axes in (left, right):
            axes.grid(True, alpha=0.3)
            axes.legend(frameon=False, fontsize=7)
    return figure


def least(truth: Array, columns: Array) -> float:
    """The least largest error of any combination of columns (points, n), by a linear program."""
    n = truth.size
    sides = np.concatenate([np.c_[columns, -np.ones(n)], np.c_[-columns, -np.ones(n)]])
    free = [(None, None)] * columns.shape[1]
    cost_ = np.r_[np.zeros(columns.shape[1]), 1.0]
    found = linprog(cost_, sides, np.r_[truth, -truth], bounds=[*free, (0.0, None)], method="highs")
    return float(found.fun)


def bound(quick: bool) -> str:
    """What no numbers of eq. 8 can do, its exponents kept: at one (alpha, mu) a time, by linear programs.

    There F_r and V_d's first factor are two numbers, and k13 a third; letting them be any functions of alpha
    and mu can only lower the error.
    """
    model = ecfit.model("microfacet-diffuse")
    alphas, cosines = (0.1, 0.3, 0.5, 0.75, 1.0), (0.01, 0.03, 0.1, 0.3, 0.7)
    axes = {
        "alpha": np.array(alphas[3:] if quick else alphas),
        "mu": np.array(cosines[:2] if quick else cosines),
        "mu_i": Axis.spaced("mu_i", 13, 0.01, 1.0, "chebyshev"),
        "cos_phi": Axis.spaced("cos_phi", 9, spacing="chebyshev"),
    }
    table = ecfit.tabulate(model, axes, quantity="brdf", quantity_options={"cosine": 1}, tolerance=1e-5)
    mu_i, cos_phi = np.meshgrid(table.axes[2].nodes, table.axes[3].nodes, indexing="ij")
    errors_: dict[tuple[float, float], float] = {}
    for i, a in enumerate(table.axes[0].nodes):
        for j, mu in enumerate(table.axes[1].nodes):
            smooth = max(1.0 - 2.0 * a, 0.0) * (1.0 - (1.0 - mu_i) ** 5) + min(2.0 * a, 1.0)
            lm = smooth * mu_i * (1.0 - 0.5 * a + 0.5 * a * mu_i)
            power = (1.0 - 0.3726732 * mu * mu) / (0.188566 + 0.38841 * mu)
            w = 1.0 - np.maximum(1.0 - mu_i, 1e-12) ** power
            s = cos_phi * np.sqrt(np.maximum((1.0 - mu * mu) * (1.0 - mu_i**2), 0.0))
            columns = np.stack([lm, w * np.maximum(s, 0.0), w * mu * mu_i * np.minimum(s, 0.0)], axis=-1)
            errors_[float(a), float(mu)] = least(table.values[i, j].ravel(), columns.reshape(-1, 3))
    (a, mu), worst = max(errors_.items(), key=lambda e: e[1])
    return (
        f"Whatever the ten numbers of eq. 8 outside its exponents are, the largest error is at least "
        f"{number(worst)} (at alpha {a:g}, mu {mu:g}): proved by linear programs, on {mu_i.size} directions "
        f"of light at each of {len(errors_)} (alpha, mu)."
    )


def main() -> None:
    parser = common.arguments(__doc__)
    parser.add_argument("--write", action="store_true", help="into docs/systems/gotanda.md and docs/figures")
    asked = parser.parse_args()
    count = 500 if asked.quick else 6000
    p, grazing = points(count, 1), points(count // 3, 2, 0.1)
    wanted, wanted_grazing = truth(p), truth(grazing)
    parts = {
        "convergence": convergence(60 if asked.quick else 300),
        "readings": readings(p, wanted),
        "accuracy": accuracy(p, wanted, grazing, wanted_grazing),
        "energy": energy(asked.quick),
        "fresnel": fresnel(),
        "validity": validity(),
        "bound": bound(asked.quick),
    }
    for name, text in parts.items():
        print(f"\n{name}\n{text}", flush=True)
    if asked.write:
        common.replace_between(PAGE, "gotanda.py", **parts)
        for name, figure in {"gotanda-diffuse": curves(), "gotanda-fresnel": fresnel_curves()}.items():
            (common.DOCS / "figures" / f"{name}.svg").write_bytes(rendered(figure, "svg"))


if __name__ == "__main__":
    main()
