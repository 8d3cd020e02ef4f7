"""Tables in C read as the look-up that they are: nodes exactly, between them linearly, clamped outside."""

from dataclasses import replace

import numpy as np
import pytest

from ecfit.approximation import Lookup, find
from ecfit.coordinates import resolve
from ecfit.export import code
from ecfit.export.compiled import STANDARDS, compiled
from ecfit.export.compilers import CC

pytestmark = pytest.mark.skipif(CC.missing() is not None, reason=str(CC.missing()))


def table(name: str, shape: tuple[int, ...], through: tuple[str, ...]):
    fit = find(name)
    values = np.random.default_rng(1).uniform(0.1, 1.0, shape)
    return replace(fit, formula=Lookup(values, fit.domain, through), name="a table")


TWO = table("conductor-10", (5, 4), ("square", "identity"))
THREE = table("dielectric-entering-20", (3, 4, 5), ("identity", "square", "fourth-power"))


@pytest.mark.parametrize(("fit", "views"), [(TWO, ()), (TWO, ("r",)), (THREE, ()), (THREE, ("r", "ior"))])
@pytest.mark.parametrize("standard", ["c99", "c++17"])
def test_it_reads_like_the_look_up(fit, views, standard):
    target = "cpp" if standard == "c++17" else "c"
    if STANDARDS[standard].missing():
        pytest.skip(str(STANDARDS[standard].missing()))
    text = code(fit, target, name="read", coordinates=views, factor=fit is TWO)
    (read,) = compiled([text], [("read", len(fit.variables))], standard)
    rng = np.random.default_rng(2)
    shown = {"mu": (-0.2, 1.2), "alpha": (-0.2, 1.2), "r": (0.0, 1.1), "F0": (0.0, 0.3), "ior": (1.0, 3.2)}
    names = [n for n in ("mu", "alpha", "r", "F0", "ior") if f"{n} in [" in text]
    at = {n: rng.uniform(*shown[n], 500) for n in names}
    for n, ends in zip(names, [(0.0, 1.0), (0.0, 1.0)], strict=False):
        at[n][:4] = [ends[0], ends[1], ends[0], ends[1]]
    inside = resolve(fit.variables, at)
    truth = fit.formula.value([inside[v] for v in fit.variables])
    np.testing.assert_allclose(read(*at.values()), truth, rtol=0, atol=3e-6)
