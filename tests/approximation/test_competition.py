"""Registered formulas against the integrals that they stand for: their errors are those on record.

docs/published-fits.md has all of them (tests/approximation/test_published.py); these are cheap to judge.

The errors pin the conventions: roughness in another view or the other masking gives a larger one. What was
tried, and how far it was off, is in docs/published-conventions.md.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

import ecfit
from ecfit._jax import jnp
from ecfit.approximation import Approximation
from ecfit.bsdf import BSDF
from ecfit.compensation.formulas import kulla_conty_fresnel
from ecfit.contract import Contract
from ecfit.coordinates import Axis
from ecfit.errors import EcfitError
from ecfit.metrics import measure
from ecfit.tables.scattered import of_contract

# name -> (mean, largest) absolute error on 24 nodes in [0.05, 1] of r and mu, in [0, 1] of F0, in [1, 3]
# of ior.
RECORDED = {
    "cycles-multi-ggx": (1.98e-4, 3.27e-4),
    "deon-average-fresnel": (9.73e-4, 1.71e-3),
    "deon-average-fresnel-leaving": (3.64e-4, 1.71e-3),
    "enterprise-pbr-2019x": (3.01e-2, 0.116),
    "enterprise-pbr-2019x-average": (2.26e-3, 4.42e-3),
    "enterprise-pbr-2019x-base": (4.56e-2, 0.264),
    "enterprise-pbr-2019x-base-average": (2.74e-2, 0.114),
    "karis-mobile": (9.58e-2, 0.194),
    "karis-mobile-a": (9.44e-2, 0.196),
    "karis-mobile-b": (1.02e-2, 8.4e-2),
    "kulla-conty-2017": (2.49e-3, 1.54e-2),
    "lazarov-2013": (0.103, 0.443),
    "lazarov-2013-a": (0.115, 0.459),
    "lazarov-2013-b": (1.79e-2, 0.335),
    "materialx-burley": (2.87e-3, 1.74e-2),
    "materialx-oren-nayar": (2.06e-3, 2.31e-2),
    "portsmouth-2024-fon": (7.91e-5, 4.67e-4),
    "materialx-ggx": (6.16e-3, 8.0e-2),
    "materialx-ggx-a": (6.11e-3, 9.94e-2),
    "materialx-ggx-b": (9.0e-4, 2.08e-2),
    "narkowicz": (7.87e-3, 4.68e-2),
    "narkowicz-a": (1.34e-2, 9.07e-2),
    "narkowicz-b": (9.48e-3, 8.39e-2),
    "osl-average-fresnel": (4.3e-3, 6.52e-3),
    "osl-average-fresnel-leaving": (6.05e-4, 2.67e-3),
}

# Closed albedos of a model with one.
CLOSED = ("burley-albedo", "portsmouth-2024-fon-average")
# Closed forms of an average.
EXACT = ("schlick-average-fresnel", "enterprise-pbr-2019x-fresnel", "f82-average-fresnel")

R, MU = (Axis.spaced(name, 24, 0.05, 1.0) for name in ("r", "mu"))
IOR = Axis.spaced("ior", 24, 1.0, 3.0)
F0 = Axis.spaced("F0", 11)
SEPARABLE, CORRELATED = "separable", "height-correlated"


# Gauss nodes in t = sqrt(mu) for averages, 2 x integral of E mu dmu.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_T = 0.5 * (_NODES + 1.0)
# Both sets of nodes in one table: half the compilations.
_ORDER = np.argsort(np.concatenate([MU.nodes, _T * _T]))
_ALL = Axis.given("mu", np.concatenate([MU.nodes, _T * _T])[_ORDER])


@cache
def _integrals(masking: str, quantity: str) -> tuple[np.ndarray, np.ndarray]:
    made = ecfit.model("conductor", masking=masking)
    table = ecfit.tabulate(made, {"r": R, "mu": _ALL}, quantity=quantity, tolerance=1e-6)
    values = table.values[:, np.argsort(_ORDER)]
    return values[:, : len(MU)], values[:, len(MU) :]


def integral(masking: str, quantity: str) -> np.ndarray:
    """The quantity of the white conductor over R and MU."""
    return _integrals(masking, quantity)[0]


def average(masking: str, quantity: str = "directional-albedo") -> np.ndarray:
    """The quantity's average over R."""
    return _integrals(masking, quantity)[1] @ (2.0 * _WEIGHTS * _T**3)


def split(masking: str) -> dict[str, np.ndarray]:
    """E1, A and B over R and MU."""
    e1, b = integral(masking, "directional-albedo"), integral(masking, "schlick-b")
    return {"directional-albedo": e1, "schlick-a": e1 - b, "schlick-b": b}


def layer(masking: str, single_f0: np.ndarray, single_f90: np.ndarray, e1: np.ndarray) -> np.ndarray:
    """The layer with its multiple scattering (Kulla & Conty 2017), F90 = 1, over F0 and more axes.

    Albedos are A, B and E1, or their averages.
    """
    shape = (-1, *(1,) * e1.ndim)
    f0 = F0.nodes.reshape(shape)
    e_avg = average(masking).reshape(-1, *(1,) * (e1.ndim - 1))
    lost = (1.0 - e1) * kulla_conty_fresnel(f0 + (1.0 - f0) / 21.0, e_avg)
    return f0 * single_f0 + single_f90 + lost


def truth(approximation: Approximation) -> ecfit.Table:
    """The table that a formula is judged on, by its contract."""
    contract, names = approximation.contract, set(approximation.variables)
    made = ecfit.model(contract.model)
    if made.exact_albedo(jnp.asarray(1.0)) is not None:
        return stated(approximation, made)
    if contract.model == "dielectric":
        made = ecfit.model("dielectric", side=contract.options["side"])
        return ecfit.tabulate(made, {"ior": IOR}, quantity=contract.quantity, tolerance=1e-8)
    values, axes = conductor(contract, names)
    return ecfit.Table.from_array(values, {axis.name: axis for axis in axes}, contract)


def stated(approximation: Approximation, made: BSDF) -> ecfit.Table:
    """The closed albedo of a model on 24 nodes of each coordinate; tests/bsdf holds it to be the integral."""
    axes = {
        n: Axis.spaced(n, 24, *d) for n, d in zip(approximation.variables, approximation.domain, strict=True)
    }
    at = dict(zip(axes, np.meshgrid(*(a.nodes for a in axes.values()), indexing="ij"), strict=True))
    mu = at.pop("mu", None)
    made = made.with_parameters({n: jnp.asarray(v) for n, v in at.items()})
    values = made.exact_average() if mu is None else made.exact_albedo(jnp.asarray(mu))
    return ecfit.Table.from_array(np.asarray(values), axes, approximation.contract)


def conductor(contract: Contract, names: set[str]) -> tuple[np.ndarray, tuple[Axis, ...]]:
    masking = contract.options.get("masking", CORRELATED)
    if contract.model == "enterprise-metallic":
        if "mu" in names:
            parts = split(masking)
            a, b, e1 = parts["schlick-a"], parts["schlick-b"], parts["directional-albedo"]
            return layer(masking, a, b, e1), (F0, R, MU)
        e1, b = average(masking), average(masking, "schlick-b")
        return layer(masking, e1 - b, b, e1), (F0, R)
    if contract.quantity == "average-albedo":
        return average(masking), (R,)
    if "mu" in contract.parameters:
        return split(masking)[contract.quantity][:, -1], (R,)
    return split(masking)[contract.quantity], (R, MU)


@pytest.mark.parametrize("name", RECORDED)
def test_the_error_is_the_recorded_one(name: str):
    approximation = ecfit.published(name)
    found = measure(approximation, truth(approximation))
    assert (found.mae, found.max_error) == pytest.approx(RECORDED[name], rel=0.1)


@pytest.mark.parametrize("name", CLOSED)
def test_closed_albedos_are_exact(name: str):
    approximation = ecfit.published(name)
    assert measure(approximation, truth(approximation)).max_error < 1e-14


def gauss_average(factor: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """2 x integral of F(x) x dx, exact for the polynomials here."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    x = 0.5 * (nodes + 1.0)
    return factor(x) @ (weights * x)


@pytest.mark.parametrize("name", EXACT)
def test_closed_forms_are_exact(name: str):
    approximation = ecfit.published(name)
    first, second = (np.linspace(0.0, 1.0, 5)[:, None, None], np.linspace(0.0, 1.0, 7)[:, None])

    def factor(x: np.ndarray) -> np.ndarray:
        if "F90" in approximation.variables:
            return first + (second - first) * (1.0 - x) ** 5
        seventh = (first + (1.0 - first) * (6.0 / 7.0) ** 5) * (1.0 - second)
        b = seventh / (1.0 / 7.0 * (6.0 / 7.0) ** 6)
        return first + (1.0 - first) * (1.0 - x) ** 5 - b * x * (1.0 - x) ** 6

    found = approximation.at([first[..., 0], second[:, 0]])
    np.testing.assert_allclose(found, gauss_average(factor), atol=1e-14)


def mae(name: str, roughness: np.ndarray, masking: str, f0: float) -> float:
    """Mean error with other numbers for the roughness. f0 < 1: of f0 A + B, from the parts -a and -b."""

    def of(part: str) -> np.ndarray:
        return ecfit.published(name + part).on_grid([roughness, MU.nodes])

    true = split(masking)
    if f0 == 1.0:
        return float(np.abs(of("") - true["directional-albedo"]).mean())
    wanted = f0 * true["schlick-a"] + true["schlick-b"]
    return float(np.abs(f0 * of("-a") + of("-b") - wanted).mean())


# name -> (power of r that the formula is given, masking, F0, other powers). Karis and Lazarov made theirs
# for F0 = 0.04. Narkowicz's is written with gloss = 1 - sqrt(r): r^2 makes it 1 - r, r^4 makes it 1 - alpha.
READINGS = {
    "materialx-ggx": (2, CORRELATED, 1.0, (1, 4)),
    "kulla-conty-2017": (1, CORRELATED, 1.0, (2, 4)),
    "enterprise-pbr-2019x": (2, CORRELATED, 1.0, (1, 4)),
    "karis-mobile": (1, SEPARABLE, 0.04, (2, 4)),
    "lazarov-2013": (1, SEPARABLE, 0.04, (2, 4)),
    "narkowicz": (1, SEPARABLE, 1.0, (2, 4)),
}


@pytest.mark.parametrize("name", READINGS)
def test_other_readings_are_worse(name: str):
    power, masking, f0, others = READINGS[name]
    kept = mae(name, R.nodes**power, masking, f0)
    other = CORRELATED if masking == SEPARABLE else SEPARABLE
    assert mae(name, R.nodes**power, other, f0) > 1.1 * kept
    for wrong in others:
        assert mae(name, R.nodes**wrong, masking, f0) > 1.3 * kept


def test_the_average_of_enterprise_pbr_is_of_alpha():
    true, made = average(CORRELATED), ecfit.published("enterprise-pbr-2019x-average")
    errors = [np.abs(made.on_grid([R.nodes**p]) - true).max() for p in (2, 1, 4)]
    assert min(errors[1:]) > 5.0 * errors[0]


def test_cycles_is_of_alpha():
    name, true = "cycles-multi-ggx", integral(SEPARABLE, "directional-albedo")[:, -1]
    errors = [np.abs(ecfit.published(name).on_grid([R.nodes**p]) - true).max() for p in (2, 1, 4)]
    assert errors[1] > 100.0 * errors[0]
    assert errors[2] > 100.0 * errors[0]


def test_the_sheen_of_materialx_is_of_the_width_itself():
    axes = {"r": np.array([0.1, 0.3, 0.6, 1.0]), "mu": np.array([0.05, 0.4, 0.9])}
    true = ecfit.tabulate("imageworks-sheen", axes, tolerance=1e-4).values
    made = ecfit.published("materialx-imageworks-sheen")
    errors = [np.abs(made.on_grid([axes["mu"], axes["r"] ** p]).T - true).mean() for p in (1.0, 2.0, 0.5)]
    assert errors[0] < 0.02
    assert min(errors[1:]) > 3.0 * errors[0]


def test_the_average_of_the_tinted_factor_is_that_of_its_model():
    model = ecfit.model("conductor", fresnel="f82-tint")
    table = ecfit.tabulate(model, {"F0": 3, "tint": 3}, quantity="average-fresnel", tolerance=1e-9)
    assert measure(ecfit.published("f82-average-fresnel"), table).max_error < 1e-9


def test_a_fit_of_what_is_not_modelled_says_so():
    found = ecfit.published("materialx-zeltner-sheen")
    assert "no truth" in found.source
    with pytest.raises(EcfitError, match="names no model"):
        of_contract(found.contract)
    # As MaterialX evaluates it: at r = 0.5, mu = 0.3, by hand.
    s, m = 0.40655785 / 0.9490774, 0.5 * (-0.379943375) / 0.546391
    assert float(found(mu=0.3, r=0.5)) == pytest.approx(
        np.exp(-0.5 * ((0.3 - m) / s) ** 2) / (s * np.sqrt(2.0 * np.pi)) + 0.5 * 0.020183373 / 0.552535,
        rel=1e-6,
    )
