"""A weighted sum of lobes is the sum of their albedos, errors included."""

import pytest

from ecfit._jax import jax, jnp
from ecfit.microfacet import NDFS, UnitFresnel
from ecfit.quadrature import HalfVectorReflection, Hemisphere, Total


def test_a_total_adds_values_and_errors_of_parts_with_other_levels():
    lobe = HalfVectorReflection(NDFS["ggx"], "separable", jnp.asarray(0.5), UnitFresnel())
    flat = Hemisphere(lambda wo, wi: jnp.where(wi[2] > 0.0, 1.0 / jnp.pi, 0.0), False)
    total = Total(((jnp.asarray(2.0), lobe), (jnp.asarray(-0.5), flat)))
    mu, level = jnp.asarray(0.4), 0
    parts = [jax.jit(lambda mu, m=m: m.albedo(mu, level, "all"))(mu) for m in (lobe, flat)]
    found = jax.jit(lambda mu: total.albedo(mu, level, "all"))(mu)
    assert float(found.value) == pytest.approx(2.0 * float(parts[0].value) - 0.5 * float(parts[1].value))
    assert float(found.error) == pytest.approx(2.0 * float(parts[0].error) + 0.5 * float(parts[1].error))
    assert len(total.levels) == 7
    assert total.levels[-1] == lobe.levels[-1] + flat.levels[-1]
    assert total.confirm
