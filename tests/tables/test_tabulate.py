"""`tabulate`: exact models, honest statuses, refused requests and keys."""

import os
import subprocess
import sys
from typing import ClassVar

import numpy as np
import pytest

import ecfit
from ecfit._jax import jnp
from ecfit.bsdf import BSDF, Conductor, Lambertian
from ecfit.coordinates import MAPS, Axis
from ecfit.errors import EcfitError
from ecfit.quadrature import Hemisphere, Status
from ecfit.tables import Request


class Coarse(Hemisphere):
    """The first levels only: each costs a compilation."""

    ORDERS: ClassVar = Hemisphere.ORDERS[:3]


class Broken(BSDF):
    """NaN for rough surfaces."""

    rough: jnp.ndarray = ecfit.parameter(0.5, 0.0, 1.0, "broken above one half")

    def f(self, wo, wi):
        return jnp.where(self.rough > 0.5, jnp.nan, jnp.where(wi[2] > 0.0, 1.0 / jnp.pi, 0.0))

    def measure(self):
        return Coarse(self.f, False)


class Unbounded(BSDF):
    """A parameter without an upper end."""

    ior: jnp.ndarray = ecfit.parameter(1.5, 1.0, float("inf"), "index of refraction")

    def f(self, wo, wi):
        return jnp.where(wi[2] > 0.0, 1.0 / (jnp.pi * self.ior), 0.0)


def test_the_lambertian_table_is_exact():
    table = ecfit.tabulate("lambertian", {"rho": 4, "mu": [0.0, 0.1, 1.0]}, tolerance=1e-9)
    expected = np.broadcast_to(np.linspace(0.0, 1.0, 4)[:, None], (4, 3))
    np.testing.assert_allclose(table.values, expected, atol=1e-9)
    assert np.all(table.status == Status.CONVERGED)
    assert np.all(table.errors <= 1e-9)
    assert np.all(np.abs(table.values - expected) <= table.errors)


def test_dimensions_keep_the_order_given():
    rho = [0.3, 0.6, 0.9]
    first = ecfit.tabulate("lambertian", {"rho": rho, "mu": [0.2, 0.8]}, tolerance=1e-5)
    last = ecfit.tabulate("lambertian", {"mu": [0.2, 0.8], "rho": rho}, tolerance=1e-5)
    assert (first.names, first.values.shape) == (("rho", "mu"), (3, 2))
    assert (last.names, last.values.shape) == (("mu", "rho"), (2, 3))
    np.testing.assert_allclose(first.values[:, 0], rho, atol=1e-5)
    np.testing.assert_allclose(last.values[0], rho, atol=1e-5)


def test_entries_agree_with_the_albedo_at_their_nodes(paper_table):
    """Clamped axes too: the value at nominal 0 is that of the clamped node."""
    rows = [(0, 0), (0, 31), (5, 17), (31, 0), (31, 31)]
    r, mu = paper_table.axes
    for i, j in rows:
        truth = ecfit.directional_albedo("conductor", r=r.nodes[i], mu=mu.nodes[j], level=3)
        error = abs(float(truth) - paper_table.values[i, j])
        assert error <= paper_table.errors[i, j] + 1e-10


SHARED = {
    "conductor": (ecfit.model("conductor", fresnel="schlick", alpha=0.4), "F0", "F0"),
    "dielectric": (ecfit.model("dielectric", side="leaving", alpha=0.4), "ior", "ior"),
    "glossy": (ecfit.model("glossy", alpha=0.4), "F0", "ior"),
}


@pytest.mark.parametrize("name", SHARED)
def test_a_row_that_shares_its_geometry_is_what_its_entries_are_alone(name):
    """An axis of the Fresnel factor, in the model's own name and in another view, first or last."""
    model, axis, parameter = SHARED[name]
    nodes, mu = {"F0": [0.02, 0.3, 0.9], "ior": [1.0, 1.3, 2.0]}[axis], [0.2, 0.7]
    # One level for all: what is compared is not the refinement.
    options = {"lobe": "reflection", "tolerance": 1e-4}
    first = ecfit.tabulate(model, {axis: nodes, "mu": mu}, **options)
    last = ecfit.tabulate(model, {"mu": mu, axis: nodes}, **options)
    assert (first.values.shape, last.values.shape) == ((3, 2), (2, 3))
    np.testing.assert_allclose(last.values.T, first.values, rtol=1e-12)
    np.testing.assert_allclose(last.errors.T, first.errors, rtol=1e-6)
    forward = MAPS["F0-to-ior"].forward if axis != parameter else float
    for value, row in zip(nodes, first.values, strict=True):
        alone = ecfit.tabulate(model.with_parameters({parameter: forward(value)}), {"mu": mu}, **options)
        np.testing.assert_allclose(alone.values, row, rtol=1e-12)


def test_the_longest_of_several_fresnel_axes_makes_the_rows():
    """Three dimensions, the shared one in the middle."""
    model = ecfit.model("conductor", fresnel="schlick", alpha=0.4)
    axes = {"F90": [0.5, 1.0], "F0": [0.0, 0.2, 0.7], "mu": [0.2, 0.7]}
    table = ecfit.tabulate(model, axes, tolerance=1e-4)
    F90, F0, mu = np.meshgrid(*axes.values(), indexing="ij")
    expected = ecfit.directional_albedo(model, mu=mu, F0=F0, F90=F90, level=1)
    np.testing.assert_allclose(table.values, expected, atol=1e-6)


def test_long_rows_are_cut_to_bound_the_memory(monkeypatch):
    """A row of entries that share their geometry may be longer than memory has room for its nodes."""
    module = sys.modules["ecfit.tables.tabulate"]
    axes = {"ior": np.linspace(1.0, 2.0, 11).tolist(), "mu": [0.2, 0.5, 0.7]}

    def table():
        return ecfit.tabulate("dielectric", axes, quantity="fresnel")  # one node an entry

    whole, held, evaluate = table(), [], module._evaluate

    def watched(model, quantity, outer, inner, level, arrays, shared, mesh):
        held.append(arrays[0].size * shared.size)
        return evaluate(model, quantity, outer, inner, level, arrays, shared, mesh)

    monkeypatch.setattr(module, "_evaluate", watched)
    monkeypatch.setattr(module, "_ROW_VALUES", 4)
    monkeypatch.setattr(module, "_BLOCK_VALUES", 8)
    cut = table()
    # Three pieces of four entries, the last filled up, of two rows and of the third with a padded one.
    assert held == [8] * 6
    np.testing.assert_allclose(cut.values, whole.values, rtol=1e-14)
    np.testing.assert_array_equal(cut.status, whole.status)


def test_a_table_of_the_fresnel_factor_alone_has_no_outer_axis():
    model = ecfit.model("dielectric")
    table = ecfit.tabulate(model, {"ior": [1.0, 1.5]}, quantity="average-fresnel")
    assert table.values.shape == (2,)
    assert table.values[0] == pytest.approx(0.0, abs=1e-9)


def test_views_of_a_parameter_give_the_same_table():
    by_r = ecfit.tabulate("conductor", {"r": [0.5, 0.8], "mu": [0.2, 0.8]}, tolerance=1e-3)
    by_alpha = ecfit.tabulate("conductor", {"alpha": [0.25, 0.64], "mu": [0.2, 0.8]}, tolerance=1e-3)
    np.testing.assert_allclose(by_alpha.values, by_r.values, atol=1e-14)


def test_a_count_spans_the_full_range():
    request = Request.make("conductor", {"r": 5, "mu": 3})
    np.testing.assert_array_equal(request.grid.axes[0].nodes, np.linspace(0.0, 1.0, 5))
    np.testing.assert_array_equal(request.grid.axes[1].nodes, [0.0, 0.5, 1.0])
    exact = Request.make(Conductor(fresnel="exact"), {"k": 3, "mu": 3})
    np.testing.assert_array_equal(exact.grid.axes[0].nodes, [0.0, 15.0, 30.0])


def test_a_model_that_returns_nan_says_so_where_it_does():
    table = ecfit.tabulate(Broken(), {"rough": [0.0, 0.4, 0.8], "mu": [0.3, 0.9]}, tolerance=1e-4)
    assert np.all(table.status[:2] == Status.CONVERGED)
    assert np.all(table.status[2] == Status.NOT_FINITE)
    assert np.all(np.isnan(table.values[2]))
    assert np.all(np.isinf(table.errors[2]))
    np.testing.assert_allclose(table.values[:2], 1.0, atol=1e-4)
    assert any("NaN" in line for line in table.describe())


def test_a_tolerance_that_no_level_meets_is_said():
    table = ecfit.tabulate("conductor", {"r": [1e-3, 0.05], "mu": [0.0, 1e-6]}, tolerance=1e-13)
    assert np.any(table.status == Status.TOLERANCE_NOT_MET)
    assert np.all((table.status == Status.CONVERGED) == (table.errors <= 1e-13))


def test_a_smaller_tolerance_gives_smaller_errors():
    axes = {"r": [0.02, 0.1], "mu": [0.01, 0.1]}
    loose, tight = (ecfit.tabulate("conductor", axes, tolerance=t) for t in (1e-3, 1e-8))
    assert loose.errors.max() <= 1e-3
    assert tight.errors.max() <= 1e-8 < loose.errors.max()
    assert np.all(np.abs(loose.values - tight.values) <= loose.errors + tight.errors)


def test_progress_counts_every_entry():
    finished: list[int] = []
    axes = {"rho": [0.1, 0.5], "mu": [0.2, 0.5, 0.9]}
    ecfit.tabulate("lambertian", axes, tolerance=1e-4, progress=finished.append)
    assert sum(finished) == 6


def test_the_contract_tells_what_was_asked():
    model = ecfit.model("conductor", fresnel="schlick", F0=0.3, masking="height-correlated")
    mu = Axis.spaced("mu", 4, 0.1, 1.0, "clamped")
    contract = Request.make(model, {"r": 3, "mu": mu}, lobe="reflection", transport="radiance").contract
    assert contract.model == "conductor"
    assert contract.options == {"ndf": "ggx", "masking": "height-correlated", "fresnel": "schlick"}
    assert contract.parameters == {"F0": 0.3, "F90": 1.0}  # alpha is an axis, eta and k have no effect
    assert (contract.lobe, contract.transport, contract.sampling) == ("reflection", "radiance", "clamped")


def test_provenance_holds_versions_and_the_key():
    request = Request.make("lambertian", {"mu": 2}, tolerance=1e-3)
    table = request.compute()
    assert table.provenance["key"] == request.key
    assert table.provenance["ecfit"] == ecfit.__version__


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ({}, "mapping such as"),
        (None, "mapping such as"),
        ([("r", 4)], "mapping such as"),
        ({"r": 4}, "needs the axis 'mu'"),
        ({"r": 4, "alpha": 4, "mu": 4}, "axes 'r' and 'alpha' are the same coordinate"),
        ({"r": 4, "mu": 1}, "count"),
        ({"r": 4, "mu": True}, "axis 'mu'"),
        ({"r": 4, "mu": 4.5}, "axis 'mu'"),
        ({"r": 4, "mu": "four"}, "axis 'mu'"),
        ({"r": 4, "mu": [0.5, 0.2]}, "must increase"),
        ({"r": 4, "mu": [0.0, 1.5]}, "outside the model's domain"),
        ({"r": 4, "mu": [-0.5, 1.0]}, "outside the model's domain"),
        ({"r": [0.5, 1.5], "mu": 4}, "outside the model's domain alpha in"),
        ({"r": [-0.5, 0.5], "mu": 4}, "must lie in"),
        ({"eta": 4, "mu": 4}, "'eta' has no effect"),
        ({"rougness": 4, "mu": 4}, "no coordinate 'rougness'"),
        ({"r": Axis.spaced("mu", 4), "mu": 4}, "given under the name 'r'"),
    ],
)
def test_bad_axes_are_refused(axes, message):
    with pytest.raises(EcfitError, match=message):
        ecfit.tabulate("conductor", axes)


@pytest.mark.parametrize("tolerance", [0.0, -1e-7, 1.0, float("nan"), float("inf"), "1e-7", None])
def test_a_tolerance_lies_between_0_and_1(tolerance):
    with pytest.raises(EcfitError, match="tolerance"):
        ecfit.tabulate("lambertian", {"mu": 3}, tolerance=tolerance)


def test_an_infinite_range_needs_ends():
    with pytest.raises(EcfitError, match="'ior' has no finite full range"):
        Request.make(Unbounded(), {"ior": 4, "mu": 4})
    by_F0 = Request.make(Unbounded(), {"F0": [0.0, 0.04], "mu": 4})
    assert by_F0.grid.axes[0].name == "F0"


def test_an_average_depends_on_no_mu():
    with pytest.raises(EcfitError, match="mu"):
        ecfit.tabulate("conductor", {"r": 4, "mu": 4}, quantity="average-albedo")


def key(model: BSDF | type[BSDF] | str = "conductor", axes=None, **options) -> str:
    return Request.make(model, axes or {"r": 4, "mu": 4}, **options).key


DIFFERENT = {
    "options": lambda: key(ecfit.model("conductor", masking="height-correlated")),
    "parameters": lambda: key(ecfit.model("conductor", alpha=0.5), {"mu": 4}),
    "other parameters": lambda: key(ecfit.model("conductor", alpha=0.6), {"mu": 4}),
    "model": lambda: key("lambertian", {"rho": 4, "mu": 4}),
    "user's model": lambda: key(type("conductor", (Conductor,), {})()),
    "count": lambda: key(axes={"r": 5, "mu": 4}),
    "order": lambda: key(axes={"mu": 4, "r": 4}),
    "view": lambda: key(axes={"alpha": 4, "mu": 4}),
    "nodes": lambda: key(axes={"r": [0.0, 0.3, 0.6, 1.0], "mu": 4}),
    "clamped": lambda: key(axes={"r": Axis.spaced("r", 4, 0.0, 1.0, "clamped"), "mu": 4}),
    "gauss": lambda: key(axes={"r": Axis.spaced("r", 4, spacing="gauss"), "mu": 4}),
    "gauss nodes as given": lambda: key(
        axes={"r": Axis.given("r", Axis.spaced("r", 4, spacing="gauss").nodes), "mu": 4}
    ),
    "lobe": lambda: key(lobe="reflection"),
    "transport": lambda: key(transport="radiance"),
    "quantity": lambda: key(axes={"r": 4}, quantity_name="average-albedo"),
    "another quantity": lambda: key(quantity_name="schlick-b"),
    "option of the quantity": lambda: key(quantity_name="schlick-b", quantity_options={"exponent": 6}),
    "tolerance": lambda: key(tolerance=1e-6),
    "default": key,
}


def test_keys_tell_requests_apart():
    """Gauss nodes that are given have another domain than the Gauss axis: fits of the two differ."""
    keys = {name: make() for name, make in DIFFERENT.items()}
    same = [(a, b) for a in keys for b in keys if a < b and keys[a] == keys[b]]
    assert same == []


def test_equal_requests_have_equal_keys():
    assert (
        key()
        == key(Conductor())
        == key(Conductor)
        == key(axes={"r": np.int64(4), "mu": Axis.spaced("mu", 4)})
    )


def test_keys_are_the_same_in_another_process(tmp_path):
    code = "from ecfit.tables import Request; print(Request.make('conductor', {'r': 4, 'mu': 4}).key)"
    environment = {**os.environ, "PYTHONHASHSEED": "12345"}
    found = subprocess.run(
        [sys.executable, "-c", code],
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert found.stdout.strip() == key()


def test_an_option_of_the_quantity_is_part_of_the_contract():
    options = {"exponent": 6}
    request = Request.make("conductor", {"r": 4, "mu": 4}, "schlick-a", quantity_options=options)
    assert dict(request.contract.quantity_options) == options
    assert Request.make("conductor", {"r": 4, "mu": 4}).contract.quantity_options == {}


def test_a_users_source_is_part_of_the_key():
    """Two models of one name and other code must not share a table: here, by their modules' files."""
    from ecfit.tables.tabulate import source_hash

    assert source_hash(Conductor) == source_hash(Lambertian) == "ecfit"
    assert source_hash(Broken) not in ("ecfit", "unknown")
