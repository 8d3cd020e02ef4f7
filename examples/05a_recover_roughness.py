"""Gradients through the integral: recover roughness and index from a noisy albedo curve.

    python examples/05a_recover_roughness.py
    python examples/05a_recover_roughness.py --output figures

Somebody has measured how much light a rough glass reflects, at 24 angles, each value with some noise. How
rough is it, and what is its index of refraction? `ecfit.directional_albedo` is a JAX function: it can be
differentiated by the parameters of the model, so Optimistix finds the curve that fits best, and the same
derivatives say how sure one may be: for independent noise of one size s the covariance of the estimates is
s^2 inv(J'J), J being the Jacobian of the curve there. s comes from what the curve leaves over, to 15 % with
24 angles (1 / sqrt(2 x 22)), and so do the sigmas.

THE MEASUREMENT IS MADE HERE: the albedo of known parameters, plus normal noise from a seed. That is what
makes the page a check. It repeats the experiment with other noise and counts how often the truth lies
within the stated uncertainty: 68 % of the time within one sigma, were they exact.

Printed: the estimates with their uncertainties, beside the truth, and that count. With --output also
`05a-recovered.png`: the measurement with the curve, and all the repeated estimates with the stated ellipse.
"""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import cyclopts
import equinox
import jax
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
import optimistix

import ecfit

NAMES = ("alpha", "ior")
TRUTH = np.array([0.3, 1.5])
START = np.array([0.6, 2.0])


class Estimate(NamedTuple):
    """(alpha, ior) and their covariance, as seen in one measurement."""

    values: np.ndarray
    covariance: np.ndarray

    @property
    def sigmas(self) -> np.ndarray:
        return np.sqrt(np.diag(self.covariance))

    @property
    def off(self) -> np.ndarray:
        """How far the truth is away, in sigmas."""
        return (self.values - TRUTH) / self.sigmas


class Found(NamedTuple):
    """What the example found, for who imports it."""

    estimate: Estimate
    repeated: list[Estimate]


def estimator(mu: jax.Array) -> Callable[[jax.Array], Estimate]:
    """What turns a measured curve, one value for each mu, into an estimate."""

    def curve(parameters: jax.Array) -> jax.Array:
        given = dict(zip(NAMES, parameters, strict=True))
        return ecfit.directional_albedo("dielectric", mu=mu, lobe="reflection", **given)

    # Any real z is an alpha in (0, 1) and an ior above 1: the solver cannot leave the model's range.
    def inside(z: jax.Array) -> jax.Array:
        return jnp.stack([jax.nn.sigmoid(z[0]), 1.0 + jnp.exp(z[1])])

    solver = optimistix.LevenbergMarquardt(rtol=1e-6, atol=1e-6)
    start = jnp.array([np.log(START[0] / (1.0 - START[0])), np.log(START[1] - 1.0)])

    @equinox.filter_jit
    def solve(measured: jax.Array) -> tuple[jax.Array, jax.Array]:
        found = optimistix.least_squares(lambda z, y: curve(inside(z)) - y, solver, start, measured)
        best = inside(found.value)
        residual, jacobian = curve(best) - measured, jax.jacfwd(curve)(best)
        variance = residual @ residual / (len(measured) - len(NAMES))  # of the noise, as seen
        return best, variance * jnp.linalg.inv(jacobian.T @ jacobian)

    return lambda measured: Estimate(*map(np.asarray, solve(measured)))


def main(*, angles: int = 24, noise: float = 0.002, repeats: int = 50, seed: int = 1,
         output: Path | None = None) -> Found:  # fmt: skip
    """Make a noisy measurement and recover what it was made from.

    Parameters
    ----------
    angles
        At which the albedo is measured, uniform in mu.
    noise
        Standard deviation of an albedo.
    repeats
        Further measurements, with other noise.
    seed
        Of the noise.
    output
        Folder for the figure; without it none is drawn.
    """
    mu = jnp.linspace(0.05, 1.0, angles)
    exact = ecfit.directional_albedo("dielectric", mu=mu, alpha=TRUTH[0], ior=TRUTH[1], lobe="reflection")
    random = np.random.default_rng(seed)
    measured = exact + noise * random.standard_normal((1 + repeats, angles))
    print(f"made here: {angles} albedos between {exact.min():.3f} and {exact.max():.3f}, noise {noise:g}")

    estimate = estimator(mu)
    first, *repeated = (estimate(curve) for curve in measured)
    for name, value, sigma, true, off in zip(NAMES, *first[:1], first.sigmas, TRUTH, first.off, strict=True):
        print(f"{name:>5} = {value:.4f} +- {sigma:.4f}   (true {true:g}, {abs(off):.1f} sigma away)")
    correlation = first.covariance[0, 1] / first.sigmas.prod()
    print(f"correlation {correlation:+.2f}")
    if repeated:
        off = np.abs([e.off for e in repeated])
        for k in (1, 2, 3):
            share = ", ".join(f"{n} {s:.0%}" for n, s in zip(NAMES, (off < k).mean(axis=0), strict=True))
            print(f"{repeats} repetitions: truth within {k} sigma: {share}")

    if output is not None:
        output.mkdir(parents=True, exist_ok=True)
        best = ecfit.directional_albedo(
            "dielectric", mu=mu, alpha=first.values[0], ior=first.values[1], lobe="reflection"
        )
        _draw(mu, measured[0], noise, best, first, repeated, output / "05a-recovered.png")
    return Found(first, repeated)


def _draw(
    mu: jax.Array, measured: jax.Array, noise: float, best: jax.Array, first: Estimate,
    repeated: list[Estimate], path: Path,
) -> None:  # fmt: skip
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
    left.errorbar(mu, measured, noise, fmt=".", color="black", label="measured (made here)")
    left.plot(mu, best, color="#D55E00", label="albedo of the estimate")
    left.set(xlabel="mu", ylabel="albedo of the reflected lobe")
    left.legend(frameon=False)
    if repeated:
        right.plot(*np.transpose([e.values for e in repeated]), ".", color="0.7", label="other noise")
    # The ellipse of two sigmas: a circle through a square root of the covariance.
    angle = np.linspace(0.0, 2.0 * np.pi, 100)
    ellipse = 2.0 * np.linalg.cholesky(first.covariance) @ np.stack([np.cos(angle), np.sin(angle)])
    right.plot(*(first.values[:, None] + ellipse), color="#D55E00", label="two sigmas, as stated")
    right.plot(*first.values, "+", color="#D55E00", label="estimate")
    right.plot(*TRUTH, "*", color="#0072B2", markersize=10, label="truth")
    right.set(xlabel=NAMES[0], ylabel=NAMES[1])
    right.locator_params(axis="x", nbins=5)
    right.legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=150)
    print(f"written: {path}")


if __name__ == "__main__":
    cyclopts.run(main, result_action="return_none")
