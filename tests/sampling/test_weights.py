"""Statistics of weights: integration and drawing agree, exact cases, and the limits that theory gives."""

import itertools

import numpy as np
import pytest

import ecfit
from ecfit._jax import jnp
from ecfit.errors import EcfitError
from ecfit.sampling import TECHNIQUES, LobeForm, drawn, integrated, lobe_form, lobe_forms, technique

EON = ecfit.model("eon")
MU = np.array([0.1, 0.6])


@pytest.mark.parametrize("name", TECHNIQUES)
def test_integration_and_drawing_agree(name: str):
    used = technique(name)
    found = integrated(EON, used, MU, 1.0)
    for i, mu in enumerate(MU):
        sample = drawn(EON, used, float(mu), 1.0, 100_000)
        assert float(sample.mean) == pytest.approx(float(found.mean[i]), abs=0.012)
        assert float(sample.largest) <= float(found.largest[i]) * 1.01
        if "ltc" not in name or "uniform" in name:  # the others have no variance
            assert float(sample.variance) == pytest.approx(float(found.variance[i]), rel=0.05)


@pytest.mark.parametrize("name", ["cosine", "uniform", "cltc+uniform"])
def test_weights_that_leave_nothing_out_have_the_albedo_as_their_mean(name: str):
    for rho in (0.4, 1.0):
        model = ecfit.model("eon", rho=rho)
        found = integrated(model, technique(name), MU, 0.7)
        made = model.with_parameters({"diffuse_roughness": jnp.asarray(0.7)})
        np.testing.assert_allclose(found.mean, np.asarray(made.exact_albedo(jnp.asarray(MU))), atol=1e-9)
        np.testing.assert_array_equal(found.beyond, 0.0)


def test_a_lambertian_has_no_variance_under_the_cosine_and_a_third_under_the_uniform_lobe():
    lambert = ecfit.model("eon", diffuse_roughness=0.0)
    cosine, uniform = (integrated(lambert, technique(n), MU, 0.0) for n in ("cosine", "uniform"))
    np.testing.assert_allclose(cosine.variance, 0.0, atol=1e-12)
    np.testing.assert_allclose(uniform.variance, 1.0 / 3.0, atol=1e-12)  # E[(2 mu)^2] - 1 = 4 / 3 - 1
    np.testing.assert_allclose(cosine.largest, 1.0, rtol=1e-12)
    # And the mixture is the cosine at r = 0.
    np.testing.assert_allclose(
        integrated(lambert, technique("cltc+uniform"), MU, 0.0).variance, 0.0, atol=1e-12
    )


def test_a_lobe_alone_misses_energy_and_has_no_variance():
    found = [integrated(EON, technique("cltc"), 0.1, 1.0, cut=cut) for cut in (1e-2, 1e-3, 1e-4)]
    assert float(found[0].beyond) > 1e-3
    assert float(found[0].mean + found[0].beyond) == pytest.approx(1.0, abs=1e-9)
    # A tenth of the cut adds as much again: the second moment grows as a logarithm.
    first, second = (float(b.variance - a.variance) for a, b in itertools.pairwise(found))
    assert first > 1e-3
    assert second == pytest.approx(first, rel=0.3)


def test_the_printed_form_is_the_listing():
    """Listings 2 and 4 at a point worked by hand; at normal incidence M is all but a scaling."""
    form = lobe_form("portsmouth-2024")
    mu, r = 0.5, 0.8
    made = form.matrix(jnp.asarray(mu), jnp.asarray(r))
    a = 1.0 + r * (0.303392 + (-0.518982 + 0.111709 * mu) * mu + (-0.276266 + 0.335918 * mu) * r)
    b = r * (-1.16407 + 1.15859 * mu + (0.150815 - 0.150105 * mu) * r) / (mu**3 - 1.43545)
    c = 1.0 + (0.20013 + (-0.506373 + 0.261777 * mu) * mu) * r
    d = ((0.540852 + (-1.01625 + 0.475392 * mu) * mu) * r) / (-1.0743 + mu * (0.0725628 + mu))
    np.testing.assert_allclose([made.a, made.b, made.c, made.d], [a, b, c, d], rtol=1e-14)
    share = r**0.1 * (0.162925 + mu * (-0.372058 + (0.538233 - 0.290822 * mu) * mu))
    assert float(form.uniform(jnp.asarray(mu), jnp.asarray(r))) == pytest.approx(share, rel=1e-14)
    top = form.matrix(jnp.asarray(1.0), jnp.asarray(1.0))
    assert float(top.a) == pytest.approx(float(top.c), abs=1e-3)
    assert abs(float(top.b)) < 0.02
    assert abs(float(top.d)) < 0.01
    assert form.count == 23


def test_wrong_names_are_refused():
    with pytest.raises(EcfitError, match="unknown technique 'ltd'.*did you mean 'ltc'"):
        technique("ltd")
    with pytest.raises(EcfitError, match="unknown lobe form 'portsmouth'"):
        technique("cltc", "portsmouth")


def test_every_form_has_densities_on_the_whole_domain():
    for name in lobe_forms():
        form = lobe_form(name)
        assert isinstance(form, LobeForm)
        for r in (0.001, 0.3, 1.0):
            for mu in np.linspace(0.0, 1.0, 21):
                made = form.matrix(jnp.asarray(mu), jnp.asarray(r))
                assert float(made.determinant) > 0.3
                assert 0.0 < float(form.uniform(jnp.asarray(mu), jnp.asarray(r))) < 0.5
