"""The tables and figures of docs/systems/msbrdf.md that no study makes.

    ecfit run configs/msbrdf.toml
    python benchmarks/msbrdf.py               # about half a minute

Readings of the printed moments, the lobe's normalisation, the roughness at which the printed factors hold,
and what a light of nine harmonics or of a polygon gets of the lobe by fits in the place of the integral.
"""

import math

import common
import numpy as np
from common import DOCS

import ecfit
from ecfit._jax import jnp
from ecfit.approximation.published import find
from ecfit.harmonics import lobe_irradiance
from ecfit.ltc import lobe_share, stretched_cosine
from ecfit.report.style import COLOURS, look, rendered

Array = np.ndarray

FITS = DOCS.parent / "results" / "msbrdf" / "fits"
FIGURES = DOCS / "figures"
MASKINGS = ("separable", "height-correlated")

# Nodes in t = sqrt(mu): E turns near grazing. With the albedo's own error, moments are good to 1e-7.
_X, _W = np.polynomial.legendre.leggauss(64)
MU = (0.5 * (_X + 1.0)) ** 2
WEIGHT = 0.5 * _W * (_X + 1.0)
ALPHA = np.linspace(0.01, 1.0, 34)


def zonal(degree: int, mu: Array = MU) -> Array:
    """Y_l0, by NumPy."""
    scale = math.sqrt((2 * degree + 1) / (4.0 * math.pi))
    return scale * np.polynomial.legendre.Legendre.basis(degree)(mu)


def moments(lost: Array, degrees: int = 3) -> Array:
    """E_l of 1 - E on `MU` (last axis): shape (..., degrees)."""
    return np.stack([2.0 * math.pi * (lost * zonal(n) * MU) @ WEIGHT for n in range(degrees)], axis=-1)


def average(lost: Array) -> Array:
    """1 - E_avg."""
    return 2.0 * (lost * MU) @ WEIGHT


def ggx_lost(masking: str, alpha: Array, mu: Array = MU) -> Array:
    """1 - E of GGX, shape (alpha, mu)."""
    model = ecfit.model("conductor", masking=masking)
    return 1.0 - np.asarray(ecfit.directional_albedo(model, mu=mu, alpha=alpha[:, None]))


def diffuse_lost(model: str, parameter: str, values: Array) -> Array:
    """1 - E of a diffuse model from its closed albedo, shape (values, mu)."""
    mu = jnp.asarray(MU)
    return np.stack([1.0 - np.asarray(ecfit.model(model, **{parameter: v}).exact_albedo(mu)) for v in values])


def cell(error: Array) -> str:
    return f"{np.abs(error).mean():.1e} / {np.abs(error).max():.1e}"


def rows(title: str, header: list[str], body: list[list[str]]) -> None:
    print(f"\n{title}\n\n| {' | '.join(header)} |\n|{'---|' * len(header)}")
    for line in body:
        print(f"| {' | '.join(line)} |")


def readings() -> None:
    """Printed moments under each reading of their argument: mean / largest error."""
    printed = [ecfit.published(f"mayaux-2018-ggx-zonal-{n}") for n in range(3)]
    body = []
    for masking in MASKINGS:
        for reading, alpha in (("alpha", ALPHA), ("r", ALPHA**2), ("alpha^2", np.sqrt(ALPHA))):
            true = moments(ggx_lost(masking, alpha))
            cells = [cell(np.asarray(p(alpha=ALPHA)) - true[:, n]) for n, p in enumerate(printed)]
            body.append([masking, reading, *cells])
    rows("GGX: the source's alpha is", ["masking", "read as", "E_0", "E_1", "E_2"], body)
    printed = [ecfit.published(f"mayaux-2018-oren-nayar-zonal-{n}") for n in range(3)]
    body = []
    for label, model, parameter, values in (
        ("qon, sigma = pi a / 2", "qon", "sigma", 0.5 * math.pi * ALPHA),
        ("qon, sigma = a", "qon", "sigma", ALPHA),
        ("qon, sigma = pi a^2 / 2", "qon", "sigma", 0.5 * math.pi * ALPHA**2),
        ("qon, sigma = sqrt(a)", "qon", "sigma", np.sqrt(ALPHA)),
        ("qon, sigma = atan(a / sqrt(2))", "qon", "sigma", np.arctan(ALPHA / math.sqrt(2.0))),
        ("fon, r = a", "fon", "diffuse_roughness", ALPHA),
    ):
        true = moments(diffuse_lost(model, parameter, values))
        # The published fits are registered as functions of sigma = pi a / 2.
        cells = [cell(np.asarray(p(sigma=0.5 * math.pi * ALPHA)) - true[:, n]) for n, p in enumerate(printed)]
        body.append([label, *cells])
    rows("Oren-Nayar: the source's alpha a is", ["read as", "E_0", "E_1", "E_2"], body)


def normalisation() -> None:
    """Furnace of the lobe: what a white surface adds to what it lacks; 1 is right."""
    body = []
    printed, ours = ecfit.published("mayaux-2018-ggx-zonal-0"), find(str(FITS / "ggx-zonal-0-rational.json"))
    for alpha in (0.1, 0.25, 0.5, 0.75, 1.0):
        lost = ggx_lost("separable", np.array([alpha]))
        left, e_0 = float(average(lost)[0]), float(moments(lost, 1)[0, 0])
        unit = 1.0 - left
        body.append(
            [
                f"{alpha:g}",
                f"{left:.4f}",
                f"{math.pi * left / (math.pi - unit):.4f}",
                f"{math.pi * left / (math.pi - math.pi * unit):.4f}",
                f"{float(printed(alpha=alpha)) / e_0:.4f}",
                f"{float(ours(alpha=alpha)) / e_0:.4f}",
            ]
        )
    header = [
        "alpha",
        "1 - E_avg",
        "pi - E_avg with E_avg <= 1",
        "pi (1 - E_avg)",
        "printed E_0",
        "ours",
    ]
    rows("White furnace of the lobe over 1 - E_o", header, body)


def bands() -> None:
    """Moments up to l = 6: how much of the lobe nine coefficients see."""
    body = []
    for alpha in (0.1, 0.25, 0.5, 1.0):
        found = moments(ggx_lost("separable", np.array([alpha])), 7)[0]
        body.append([f"GGX alpha {alpha:g}", *(f"{v / found[0]:.4f}" for v in found[1:])])
    for sigma in (0.4, 0.8, 1.5):
        found = moments(diffuse_lost("qon", "sigma", np.array([sigma])), 7)[0]
        body.append([f"qon sigma {sigma:g}", *(f"{v / found[0]:.4f}" for v in found[1:])])
    rows("E_l / E_0", ["lobe", *(f"l = {n}" for n in range(1, 7))], body)


def environments() -> None:
    """Irradiance of random environments by fitted moments, against exact moments."""
    random = np.random.default_rng(2018)
    light = random.normal(size=(4000, 9))
    light[:, 0] = 3.0 * np.abs(light[:, 0])
    normal = random.normal(size=(4000, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    body = []
    for alpha in (0.25, 0.5, 0.75, 1.0):
        true = moments(ggx_lost("separable", np.array([alpha])))[0]
        exact = np.asarray(lobe_irradiance(light, true, normal))
        cells = []
        for names in (
            [f"mayaux-2018-ggx-zonal-{n}" for n in range(3)],
            [str(FITS / f"ggx-zonal-{n}-rational.json") for n in range(3)],
        ):
            fitted = np.array([float(find(name)(alpha=alpha)) for name in names])
            error = np.asarray(lobe_irradiance(light, fitted, normal)) - exact
            cells.append(f"{np.sqrt((error**2).mean() / (exact**2).mean()):.2e}")
        body.append([f"{alpha:g}", *cells])
    rows("Relative RMS error of the irradiance, 4000 environments", ["alpha", "printed", "ours"], body)


def saturation() -> None:
    """The roughness at which the printed factors are the series, and the least error without a roughness."""
    F0 = np.linspace(0.0, 1.0, 101)
    F = (20.0 * F0 + 1.0) / 21.0
    printed = F0 * (0.04 + F0 * (0.66 + 0.3 * F0))
    # 1 - E_avg at the least distance.
    lost = average(ggx_lost("separable", ALPHA))
    series = F**2 * (1.0 - lost[:, None]) / (1.0 - F * lost[:, None])
    fine = np.linspace(0.3, 0.7, 401)
    at = np.interp(fine, ALPHA, lost)[:, None]
    rms = np.sqrt(np.mean((F**2 * (1.0 - at) / (1.0 - F * at) - printed) ** 2, axis=1))
    best = int(np.argmin(rms))
    print(f"\nThe printed F0 factor is the series best at alpha = {fine[best]:.3f}: RMS {rms[best]:.1e}")
    print(f"without a roughness no factor is better than {0.5 * np.ptp(series, axis=0).max():.4f} at worst")
    tau = 0.28430405702379613
    sigma = np.linspace(0.01, 0.5 * math.pi, 2001)
    lost = 1.0 - np.array([np.asarray(ecfit.model("qon", sigma=s).exact_average()) for s in sigma])
    print(f"tau = {tau:.4f} is 1 - E_avg of qon at sigma = {np.interp(tau, lost, sigma):.4f}")
    rho = F0
    series = rho**2 * (1.0 - lost[:, None]) / (1.0 - rho * lost[:, None])
    print(f"without a roughness no factor is better than {0.5 * np.ptp(series, axis=0).max():.4f} at worst")


def lobe_errors(lost: Array, scale: float) -> float:
    """Energy in the wrong place: the integral of |D - lobe|, both lobes with the integral 1."""
    lobe = lost * MU / (math.pi * average(lost))
    return float(2.0 * math.pi * WEIGHT @ np.abs(np.asarray(stretched_cosine(MU, scale)) - lobe))


def cosines() -> None:
    """Transformed cosines against the lobe: part of its light that is in the wrong place."""
    body = []
    for masking, name in zip(MASKINGS, ("ggx-ltc-4", "ggx-correlated-ltc-4"), strict=True):
        form = find(str(FITS / f"{name}.json"))
        for alpha in (0.05, 0.1, 0.15, 0.25, 0.5, 0.75, 1.0):
            lost = ggx_lost(masking, np.array([alpha]))[0]
            scale = float(form(alpha=alpha))
            plain, fitted = lobe_errors(lost, 1.0), lobe_errors(lost, scale)
            left = float(average(lost))
            body.append([masking, f"{alpha:g}", f"{left:.4f}", f"{scale:.3f}", f"{plain:.4f}",
                         f"{fitted:.4f}", f"{fitted * left:.5f}"])  # fmt: skip
    form = find(str(FITS / "oren-nayar-ltc-3.json"))
    for sigma in (0.2, 0.4, 0.8, 1.2, 1.57):
        lost = diffuse_lost("qon", "sigma", np.array([sigma]))[0]
        scale = float(form(sigma=sigma))
        plain, fitted, left = lobe_errors(lost, 1.0), lobe_errors(lost, scale), float(average(lost))
        body.append(["qon", f"sigma {sigma:g}", f"{left:.4f}", f"{scale:.3f}", f"{plain:.4f}",
                     f"{fitted:.4f}", f"{fitted * left:.5f}"])  # fmt: skip
    header = ["model", "alpha", "1 - E_avg", "a", "a = 1", "a of the form", "times 1 - E_avg"]
    rows("Part of the lobe's light in the wrong place", header, body)


def polygons() -> None:
    """Shares of square lights, 1 wide, that face the surface or stand on it: closed form against the lobe."""
    half = 0.5
    lights = {
        "overhead, 1 high": [[-half, -half, 1], [half, -half, 1], [half, half, 1], [-half, half, 1]],
        "0.3 high, aside": [[half, -half, 0.3], [1.5, -half, 0.3], [1.5, half, 0.3], [half, half, 0.3]],
        "wall on the ground, 1 away": [[1, -half, 0], [1, half, 0], [1, half, 1], [1, -half, 1]],
    }  # fmt: skip
    x, w = np.polynomial.legendre.leggauss(48)
    s, ws = (0.5 * (x + 1.0)) ** 2, 0.5 * w * (x + 1.0)  # clustered at the first edge, on the ground
    t, wt = 0.5 * (x + 1.0), 0.5 * w
    form = find(str(FITS / "ggx-ltc-4.json"))
    body = []
    for label, corners in lights.items():
        p = np.array(corners, dtype=float)
        along, up = p[1] - p[0], p[3] - p[0]
        at = p[0] + t[:, None, None] * along + s[None, :, None] * up
        r2 = np.sum(at * at, axis=-1)
        omega = np.abs(at @ np.cross(along, up)) / r2**1.5
        mu = at[..., 2] / np.sqrt(r2)
        for alpha in (0.25, 0.5, 1.0):
            lost = ggx_lost("separable", np.array([alpha]))[0]
            seen = ggx_lost("separable", np.array([alpha]), mu.ravel())[0].reshape(mu.shape)
            true = wt @ (seen * mu * omega) @ ws / (math.pi * average(lost))
            share, plain = (float(lobe_share(p, a)) for a in (float(form(alpha=alpha)), 1.0))
            body.append([label, f"{alpha:g}", f"{true:.4f}", f"{share - true:+.4f}", f"{plain - true:+.4f}"])
    rows("Share of the lobe's light", ["light", "alpha", "lobe", "a of the form", "a = 1"], body)


def figures() -> None:
    """docs/figures/msbrdf-*.svg."""
    from matplotlib.figure import Figure

    alpha = np.linspace(0.01, 1.0, 100)
    true = moments(ggx_lost("separable", alpha))
    sigma = 0.5 * math.pi * alpha
    diffuse = moments(diffuse_lost("qon", "sigma", sigma))
    colours = (COLOURS["rational"], COLOURS["other"], COLOURS["polynomial"])
    with look():
        figure = Figure(figsize=(7.2, 4.6), layout="constrained")
        axes = figure.subplots(2, 2, sharex=True)
        for column, (name, values, coordinate, ours) in enumerate(
            (("ggx", true, {"alpha": alpha}, "rational"), ("oren-nayar", diffuse, {"sigma": sigma}, "exact"))
        ):
            above, below = axes[0, column], axes[1, column]
            for n, colour in enumerate(colours):
                printed = np.asarray(ecfit.published(f"mayaux-2018-{name}-zonal-{n}")(**coordinate))
                best = np.asarray(find(str(FITS / f"{name}-zonal-{n}-{ours}.json"))(**coordinate))
                above.plot(alpha, values[:, n], color=colour, label=f"$E_{n}$")
                above.plot(alpha, printed, color=colour, linestyle=":")
                below.plot(alpha, printed - values[:, n], color=colour, linestyle=":")
                below.plot(alpha, best - values[:, n], color=colour)
            above.set_title("GGX, separable" if name == "ggx" else "Oren-Nayar (qon)")
            below.set_xlabel("alpha" if name == "ggx" else "2 sigma / pi")
            below.axhline(0.0, color="0.7", linewidth=0.6)
        axes[0, 0].set_ylabel("moment")
        axes[1, 0].set_ylabel("error (dotted: printed)")
        axes[0, 0].legend(frameon=False)
        (FIGURES / "msbrdf-moments.svg").write_bytes(rendered(figure, "svg"))

        figure = Figure(figsize=(7.2, 2.8), layout="constrained")
        left, right = figure.subplots(1, 2)
        mu = np.linspace(0.001, 1.0, 120)
        form = find(str(FITS / "ggx-ltc-4.json"))
        for value, colour in zip((0.1, 0.3, 1.0), colours, strict=True):
            lost = ggx_lost("separable", np.array([value]))[0]
            shown = ggx_lost("separable", np.array([value]), mu)[0] * mu / (math.pi * average(lost))
            left.plot(mu, shown, color=colour, label=f"alpha = {value:g}")
            left.plot(mu, stretched_cosine(mu, float(form(alpha=value))), color=colour, linestyle="--")
        left.set(xlabel="mu", ylabel="lobe / sr", title="Lobe, and its transformed cosine (dashed)")
        left.legend(frameon=False)
        shown = alpha[alpha >= 0.04]
        for name, colour, label in zip(
            ("ggx-ltc-4", "ggx-correlated-ltc-4"),
            colours,
            ("GGX separable", "height-correlated"),
            strict=False,
        ):
            right.plot(shown, find(str(FITS / f"{name}.json"))(alpha=shown), color=colour, label=label)
        found = find(str(FITS / "oren-nayar-ltc-3.json"))(sigma=0.5 * math.pi * shown)
        right.plot(shown, found, color=colours[2], label="qon, 2 sigma / pi")
        right.set(xlabel="alpha", ylabel="a of M = diag(a, a, 1)", yscale="log", title="M(alpha)")
        right.legend(frameon=False)
        (FIGURES / "msbrdf-ltc.svg").write_bytes(rendered(figure, "svg"))


def main() -> None:
    common.arguments(__doc__).parse_args()
    for part in (readings, normalisation, bands, environments, saturation, cosines, polygons, figures):
        part()


if __name__ == "__main__":
    main()
