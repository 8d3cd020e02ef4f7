"""`check_bsdf`: does a model keep the promises that the rest of ecfit relies on?"""

from collections.abc import Callable
from dataclasses import dataclass

import equinox as eqx
import numpy as np

from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF, as_model
from ecfit.bsdf.registry import name_of
from ecfit.errors import EcfitError
from ecfit.tables import tabulate

Array = jax.Array

# Rounding of a BSDF value; the reciprocity of a sharp lobe loses digits in normalising the half vector.
_RELATIVE = 1e-8
_ENERGY_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Finding:
    """One property of a model: whether it holds, and where it fails most."""

    name: str
    passed: bool
    detail: str


@dataclass(frozen=True)
class BSDFCheck:
    """The findings of `check_bsdf`; true where all of them passed."""

    model: str
    findings: tuple[Finding, ...]

    @property
    def passed(self) -> bool:
        return all(f.passed for f in self.findings)

    def __bool__(self) -> bool:
        return self.passed

    def __str__(self) -> str:
        width = max(len(f.name) for f in self.findings)
        lines = [f"{self.model}: {'passed' if self.passed else 'FAILED'}"]
        lines += [f"  {'ok  ' if f.passed else 'FAIL'}  {f.name:<{width}}  {f.detail}" for f in self.findings]
        return "\n".join(lines)


def _directions(rng: np.random.Generator, count: int, above: bool) -> np.ndarray:
    """Unit vectors uniform on a hemisphere, shape (count, 3)."""
    z = rng.uniform(0.0, 1.0, count)
    phi = rng.uniform(0.0, 2.0 * np.pi, count)
    s = np.sqrt(1.0 - z * z)
    return np.stack([s * np.cos(phi), s * np.sin(phi), z if above else -z], axis=1)


def _settings(model: BSDF, rng: np.random.Generator, count: int) -> list[dict[str, float]]:
    """The model's own parameters, then random ones from their ranges (cut to what a test can integrate)."""
    names = model.active_parameters()
    out = [{n: float(model.parameter_value(n)) for n in names}]
    ranges = model.parameter_ranges()
    for _ in range(count):
        point = {}
        for name in names:
            low, high = ranges[name]
            low, high = (low if np.isfinite(low) else -10.0), (high if np.isfinite(high) else low + 10.0)
            point[name] = float(rng.uniform(low + 0.1 * (high - low), high))
        out.append(point)
    return out


def _at(index: int, settings: dict[str, float], wo: np.ndarray, wi: np.ndarray) -> str:
    parameters = ", ".join(f"{k} = {v:.4g}" for k, v in settings.items())
    o, i = (np.array2string(v[index], precision=4) for v in (wo, wi))
    return f"wo = {o}, wi = {i}" + (f", {parameters}" if parameters else "")


def check_bsdf(model: BSDF | type[BSDF] | str, *, samples: int = 500, seed: int = 0) -> BSDFCheck:
    """Check a model: shape, finite, non-negative, reciprocal, energy, side, jit / vmap / grad.

    Args:
        model: a BSDF, its class, or a registered name.
        samples: directions tried for each setting of the parameters.
        seed: of the random directions and parameters.

    Returns a `BSDFCheck`: printable, and false where something failed. Reciprocity and energy <= 1 are
    checked where the model claims them (`reciprocal`, `conserving`). Raises `EcfitError` only where the
    model cannot be made at all.
    """
    bsdf = as_model(model)
    rng = np.random.default_rng(seed)
    wo, wi, below = (_directions(rng, samples, above) for above in (True, True, False))
    settings = _settings(bsdf, rng, 3)
    first = _runs(bsdf, wo, wi)
    findings = [first]
    if first.passed:
        checks: tuple[Callable[..., Finding], ...] = (_finite, _non_negative, _reciprocal, _other_side)
        findings += [check(bsdf, settings, wo, wi, below) for check in checks]
        findings += [_gradients(bsdf, wo, wi), _energy(bsdf, settings), _exact(bsdf, settings)]
    return BSDFCheck(name_of(bsdf), tuple(findings))


@eqx.filter_jit
def _f(model: BSDF, wo: np.ndarray, wi: np.ndarray) -> Array:
    return jax.vmap(model.f)(jnp.asarray(wo), jnp.asarray(wi))


def _values(bsdf: BSDF, point: dict[str, float], wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    # The model is an argument: all settings of its parameters share one compilation.
    return np.asarray(_f(bsdf.with_parameters({k: jnp.asarray(v) for k, v in point.items()}), wo, wi))


def _runs(bsdf: BSDF, wo: np.ndarray, wi: np.ndarray) -> Finding:
    """f gives one real number under plain calls, jit and vmap, and the same one."""
    name = "runs under jit and vmap"
    try:
        plain = np.asarray(bsdf.f(jnp.asarray(wo[0]), jnp.asarray(wi[0])))
        if plain.shape != () or not np.issubdtype(plain.dtype, np.floating):
            return Finding(
                name, False, f"f must return a real scalar, got {plain.dtype} of shape {plain.shape}"
            )
        vectorised = np.asarray(jax.jit(jax.vmap(bsdf.f))(wo, wi))
    except EcfitError:
        raise
    except Exception as error:  # whatever the user's code raises is the finding
        first = str(error).strip().splitlines() or [""]
        return Finding(name, False, f"{type(error).__name__}: {first[0]}")
    same = np.allclose(vectorised[0], plain, rtol=1e-12, atol=0.0, equal_nan=True)
    return Finding(name, bool(same), f"{len(wo)} directions" if same else "jit changes the value of f")


def _finite(bsdf, settings, wo, wi, below) -> Finding:
    for point in settings:
        for other in (wi, below):
            values = _values(bsdf, point, wo, other)
            bad = np.flatnonzero(~np.isfinite(values))
            if bad.size:
                return Finding("finite", False, f"f = {values[bad[0]]} at {_at(bad[0], point, wo, other)}")
    return Finding("finite", True, f"{len(settings)} settings of the parameters")


def _non_negative(bsdf, settings, wo, wi, below) -> Finding:
    least, where = 0.0, ""
    for point in settings:
        for other in (wi, below):
            values = _values(bsdf, point, wo, other)
            if np.nanmin(values) < least:
                index = int(np.nanargmin(values))
                least, where = float(values[index]), _at(index, point, wo, other)
    return Finding("non-negative", least >= 0.0, f"f = {least:.3g} at {where}" if where else "")


def _reciprocal(bsdf, settings, wo, wi, below) -> Finding:
    name = "reciprocal"
    if not bsdf.reciprocal:
        return Finding(name, True, "not claimed")
    worst, where = 0.0, ""
    for point in settings:
        there, back = _values(bsdf, point, wo, wi), _values(bsdf, point, wi, wo)
        difference = np.abs(there - back) / np.maximum(np.maximum(np.abs(there), np.abs(back)), 1e-12)
        index = int(np.nanargmax(difference))
        if difference[index] > worst:
            worst, where = float(difference[index]), _at(index, point, wo, wi)
    passed = worst <= _RELATIVE
    return Finding(name, passed, f"relative difference {worst:.2g}" + ("" if passed else f" at {where}"))


def _other_side(bsdf, settings, wo, wi, below) -> Finding:
    name = "zero below the horizon"
    if bsdf.transmissive:
        return Finding(name, True, "transmissive: not claimed")
    for point in settings:
        values = _values(bsdf, point, wo, below)
        if np.any(values != 0.0):
            index = int(np.flatnonzero(values != 0.0)[0])
            place = _at(index, point, wo, below)
            return Finding(name, False, f"f = {values[index]:.3g} at {place}; or set transmissive = True")
    return Finding(name, True, "")


def _gradients(bsdf: BSDF, wo: np.ndarray, wi: np.ndarray) -> Finding:
    """d f / d parameter is finite everywhere, and agrees with a central difference."""
    name = "gradients"
    names = bsdf.active_parameters()
    if not names:
        return Finding(name, True, "no parameters")
    for parameter in names:
        value = float(getattr(bsdf, parameter))
        low, high = bsdf.parameter_ranges()[parameter]
        step = 1e-6 * max(1.0, abs(value))
        centre = float(np.clip(value, low + step, high - step))

        def f(x: Array, o: Array, i: Array, parameter: str = parameter) -> Array:
            return bsdf.with_parameters({parameter: x}).f(o, i)

        # One compilation gives the slope and the values on both sides.
        both = jax.jit(jax.vmap(jax.value_and_grad(f), (None, 0, 0)))
        try:
            slope = both(centre, wo, wi)[1]
        except Exception as error:  # whatever the user's code raises is the finding
            return Finding(name, False, f"d f / d {parameter}: {type(error).__name__}")
        slope = np.asarray(slope)
        if not np.all(np.isfinite(slope)):
            bad = int(np.flatnonzero(~np.isfinite(slope))[0])
            at = _at(bad, {parameter: centre}, wo, wi)
            return Finding(name, False, f"d f / d {parameter} = {slope[bad]} at {at}")
        above, below = (both(centre + shift, wo, wi)[0] for shift in (step, -step))
        difference = np.asarray(above - below) / (2.0 * step)
        error = np.abs(slope - difference) / (1.0 + np.abs(difference))
        # A kink of f may lie within the step of a few directions: judge the bulk.
        if np.quantile(error, 0.98) > 1e-3:
            bad = int(np.argmax(error))
            return Finding(
                name,
                False,
                f"d f / d {parameter} = {slope[bad]:.4g}, by differences {difference[bad]:.4g} at "
                f"{_at(bad, {parameter: centre}, wo, wi)}",
            )
    return Finding(name, True, f"with respect to {', '.join(names)}")


def _energy(bsdf: BSDF, settings: list[dict[str, float]]) -> Finding:
    """The albedo in energy transport does not exceed 1 (beyond its error estimate)."""
    name = "energy <= 1"
    if not bsdf.conserving:
        return Finding(name, True, "not claimed")
    largest, where, unsure = 0.0, "", 0
    for point in settings:
        made = bsdf.with_parameters({k: jnp.asarray(v) for k, v in point.items()})
        table = tabulate(made, {"mu": np.array([0.05, 0.3, 0.7, 1.0])}, tolerance=_ENERGY_TOLERANCE)
        unsure += int(np.count_nonzero(table.status))
        excess = table.values - np.where(np.isfinite(table.errors), table.errors, 0.0)
        index = int(np.nanargmax(excess)) if np.isfinite(excess).any() else 0
        if not np.isfinite(table.values[index]) or table.values[index] > largest:
            largest = float(table.values[index])
            parameters = "".join(f", {k} = {v:.4g}" for k, v in point.items())
            where = f"mu = {table.axes[0].nodes[index]:.2g}{parameters}"
    passed = bool(largest <= 1.0 + _ENERGY_TOLERANCE)
    note = f"; {unsure} integrals did not reach {_ENERGY_TOLERANCE:g}" if unsure else ""
    return Finding(name, passed, f"largest albedo {largest:.6g} at {where}{note}")


def _exact(bsdf: BSDF, settings: list[dict[str, float]]) -> Finding:
    """The model's closed form, where it has one, is the integral."""
    name = "exact albedo"
    mu = np.array([0.1, 0.5, 1.0])
    if bsdf.exact_albedo(jnp.asarray(mu)) is None:
        return Finding(name, True, "not given")
    worst = 0.0
    for point in settings:
        made = bsdf.with_parameters({k: jnp.asarray(v) for k, v in point.items()})
        table = tabulate(made, {"mu": mu}, tolerance=1e-9)
        worst = max(
            worst, float(np.max(np.abs(np.asarray(made.exact_albedo(jnp.asarray(mu))) - table.values)))
        )
    return Finding(name, worst <= 1e-8, f"differs from the integral by {worst:.2g}")
