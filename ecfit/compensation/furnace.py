"""The numerical white furnace: the albedo of a compensated model, which should be 1."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ecfit.approximation import Approximation
from ecfit.bsdf import BSDF
from ecfit.compensation.compensated import Compensated, compensate
from ecfit.compensation.glossy import Glossy
from ecfit.errors import EcfitError
from ecfit.tables import Table, tabulate


@dataclass(frozen=True, eq=False)
class Furnace:
    """The integral of a compensated BSDF over wi at every node of a grid.

    Attributes:
        table: the integrals with their error estimates.
    """

    table: Table

    @property
    def deviation(self) -> np.ndarray:
        """Integral - 1: negative where energy is lost, positive where it is made. The table's shape."""
        return self.table.values - 1.0

    @property
    def mean(self) -> float:
        """Mean of the absolute deviation."""
        return float(np.mean(np.abs(self.deviation)))

    @property
    def p99(self) -> float:
        """99th percentile of the absolute deviation."""
        return float(np.quantile(np.abs(self.deviation), 0.99))

    @property
    def max(self) -> float:
        """Largest absolute deviation."""
        return float(np.max(np.abs(self.deviation)))

    @property
    def place(self) -> dict[str, float]:
        """Coordinates of the largest deviation."""
        worst = np.unravel_index(int(np.argmax(np.abs(self.deviation))), self.deviation.shape)
        return {a.name: float(a.nodes[i]) for a, i in zip(self.table.axes, worst, strict=True)}

    def describe(self) -> list[str]:
        """Lines for people to read."""
        at = ", ".join(f"{k} = {v:.4g}" for k, v in self.place.items())
        low, high = float(self.deviation.min()), float(self.deviation.max())
        missed = int(np.count_nonzero(self.table.status))
        return [
            f"white furnace: |integral - 1| mean {self.mean:.2e}, 99 % below {self.p99:.2e}, "
            f"largest {self.max:.2e} at {at}",
            f"energy lost at most {max(-low, 0.0):.2e}, made at most {max(high, 0.0):.2e}; "
            f"{missed} of {self.deviation.size} integrals missed the tolerance {self.table.tolerance:g}",
        ]


def furnace(
    model: BSDF,
    axes: Mapping[str, object],
    *,
    transport: str = "energy",
    tolerance: float = 1e-6,
) -> Furnace:
    """Integrate a compensated model over wi at every node of a grid.

    Args:
        model: what `compensate` returns, a `glossy` model over a white diffuse base, or any BSDF that should
            keep all energy.
        axes: as for `ecfit.tabulate`.
        transport: "energy", or "radiance" for models compensated by such tables.
        tolerance: absolute error of each integral.

    Returns a `Furnace`. Raises `EcfitError` for unknown names and axes outside the model's domain.
    """
    return Furnace(tabulate(model, axes, transport=transport, tolerance=tolerance))


def furnace_of(
    model: BSDF,
    albedo: Approximation | None,
    axes: Mapping[str, object],
    *,
    method: str = "turquin",
    transport: str = "energy",
    tolerance: float = 1e-6,
) -> Furnace:
    """The furnace of a model compensated by an approximation of its albedo.

    A `glossy` model takes it for E_spec, over a white base (Sforza & Pellacini 2022, eq. 18); for all others
    see `compensate`, also for its arguments and errors; `axes`, `transport` and `tolerance` as for `furnace`.
    Raises `EcfitError` for a glossy layer with another method than "turquin".
    """
    if isinstance(model, Glossy):
        if method != "turquin":
            raise EcfitError("a glossy layer is compensated by scaling: method must be 'turquin'")
        whole: BSDF = Glossy(
            alpha=model.alpha,
            ior=model.ior,
            F90=model.F90,
            ndf=model.ndf,
            masking=model.masking,
            fresnel=model.fresnel,
            base="diffuse",
            layer=albedo,
        )
    else:
        settings = {"transport": transport}  # an exact albedo must be that of the measured transport
        whole = model if isinstance(model, Compensated) else compensate(model, albedo, method, **settings)
    return furnace(whole, axes, transport=transport, tolerance=tolerance)
