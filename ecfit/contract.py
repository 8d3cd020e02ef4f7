"""The contract: every convention that gives a number of ecfit its meaning, as data."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

from ecfit.errors import EcfitError, unknown

QUANTITIES = {
    "directional-albedo": "E(mu): integral of f |cos theta_i| over wi",
    "average-albedo": "E_avg: 2 x integral of E(mu) mu over mu in [0, 1]",
    "schlick-a": "A of E = F0 A + F90 B: integral over the lobe with 1 - (1 - wo.h)^exponent for F",
    "schlick-b": "B of E = F0 A + F90 B: integral over the lobe with (1 - wo.h)^exponent for F",
    "f82-moment": "integral over the lobe with x (1 - x)^6, x = wo.h, for F: the F82 model's third term",
    "average-fresnel": "F_avg: 2 x integral of F(x) x over x in [0, 1]",
    "zonal-moment": "E_l: 2 pi x integral of Y_l0(mu) (1 - E(mu)) mu over mu in [0, 1], l = degree",
    "multiple-bounces": "S = F^2 E_avg / (1 - F (1 - E_avg)), F the mean reflectance of a bounce",
    "ltc-scale": "a of M = diag(a, a, 1), the linearly transformed cosine nearest to (1 - E(mu)) mu",
    "fresnel": "F(mu): the Fresnel factor of one facet",
    "brdf": "f(wo, wi) at mu, mu_i and cos_phi of the azimuth between them; times mu_i with cosine = 1",
}
LOBES = {
    "all": "reflection and transmission",
    "reflection": "wi on the side of wo",
    "transmission": "wi on the other side",
}
TRANSPORTS = {
    "energy": "the transmitted lobe scaled by eta^2: the measure that is preserved",
    "radiance": "the BSDF as rendered, without eta^2",
}


@dataclass(frozen=True)
class Contract:
    """What a table or an approximation stands for.

    Attributes:
        model: registered name of the BSDF, or "unknown" for a foreign table.
        options: the model's options in words: masking, ndf, fresnel, side, ...
        parameters: values of the model's parameters that are not axes.
        quantity, lobe, transport: names of `QUANTITIES`, `LOBES`, `TRANSPORTS`.
        quantity_options: settings of the quantity in numbers: exponent, ...
        stored: "E" (a table of 1 - E is converted on reading).
        sampling: "clamped" where nodes differ from the coordinates that a fit sees, else "true".

    Raises `EcfitError` for names that it does not know, and settings that are not words (options) or
    numbers.
    """

    model: str
    options: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, float] = field(default_factory=dict)
    quantity: str = "directional-albedo"
    lobe: str = "all"
    transport: str = "energy"
    quantity_options: Mapping[str, float] = field(default_factory=dict)
    stored: str = "E"
    sampling: str = "true"

    def __post_init__(self) -> None:
        for kind, name, valid in (
            ("quantity", self.quantity, QUANTITIES),
            ("lobe", self.lobe, LOBES),
            ("transport", self.transport, TRANSPORTS),
            ("stored value", self.stored, ("E",)),
            ("sampling", self.sampling, ("true", "clamped")),
        ):
            if not isinstance(name, str) or name not in valid:
                raise unknown(kind, name, valid)

        if not isinstance(self.model, str) or not self.model:
            raise EcfitError(f"a contract's model must be a name, got {self.model!r}")
        numbers = int | float
        for label, kind in (("options", str), ("parameters", numbers), ("quantity_options", numbers)):
            given = getattr(self, label)
            if not isinstance(given, Mapping) or not all(
                isinstance(k, str) and isinstance(v, kind) and not isinstance(v, bool)
                for k, v in given.items()
            ):
                raise EcfitError(f"a contract's {label} must map names to settings, got {given!r}")

    def differences(self, other: "Contract") -> list[str]:
        """What `self` says otherwise than `other`, in words; sampling and parameters apart."""
        out = []
        for name in ("model", "quantity", "lobe", "transport"):
            if getattr(self, name) != getattr(other, name):
                out.append(f"{name} = {getattr(self, name)}")
        for name, value in sorted(self.options.items()):
            if name in other.options and other.options[name] != value:
                out.append(f"{name} = {value}")
        return out

    def to_dict(self) -> dict[str, Any]:
        """A JSON-ready dictionary."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> "Contract":
        """The inverse of `to_dict`; raises `EcfitError` for unknown or missing keys."""
        known = {f.name for f in fields(cls)}
        if not isinstance(data, Mapping) or "model" not in data:
            raise EcfitError("a contract must be a mapping with at least the key 'model'")
        for key in data:
            if key not in known:
                raise unknown("contract key", key, known)
        return cls(**data)

    def describe(self) -> list[tuple[str, str]]:
        """(label, value) rows for people to read."""
        rows = [("model", self.model)]
        rows += sorted((k, str(v)) for k, v in self.options.items())
        rows += sorted((k, f"{v:g}") for k, v in self.parameters.items())
        rows += [
            ("quantity", f"{self.quantity} ({QUANTITIES[self.quantity]})"),
            *sorted((k, f"{v:g}") for k, v in self.quantity_options.items()),
            ("lobe", self.lobe),
            ("transport", self.transport),
            ("stored", self.stored),
            ("sampling", self.sampling),
        ]
        return rows
