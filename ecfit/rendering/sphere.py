"""One sphere to render, as plain data that passes to the process that renders it. No JAX here."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from ecfit.coordinates import resolve

# To be changed when pictures of the same config change.
RENDERING_VERSION = 1


@dataclass(frozen=True)
class AlbedoCode:
    """E(mu) at one roughness and index of refraction, as plain data.

    Attributes:
        name: of the approximation.
        text: exported Python code of a function `E`; "" for a table.
        fixed: the function's other arguments.
        nodes, values: E at nodes of mu, linear in between; () for code. (A multilinear look-up is linear
            between values that are interpolated in all other coordinates first.)
    """

    name: str
    text: str = ""
    fixed: Mapping[str, float] = field(default_factory=dict)
    nodes: tuple[float, ...] = ()
    values: tuple[float, ...] = ()


@dataclass(frozen=True)
class Sphere:
    """One sphere to render: all that its picture depends on, as plain data.

    Attributes:
        material, row: names in the config.
        model, r, ior, eta, k, rho, light: of the material.
        albedos: role -> the code or table that stands for E; empty where nothing is compensated.
        outside: roles whose approximation is used outside its domain.
        pixels, samples, seeds, candidates, depth: of the config.
    """

    material: str
    row: str
    model: str
    light: str
    r: float
    ior: float | None
    eta: tuple[float, ...] | None
    k: tuple[float, ...] | None
    rho: tuple[float, ...]
    albedos: Mapping[str, AlbedoCode]
    outside: tuple[str, ...]
    pixels: int
    samples: int
    seeds: int
    candidates: int
    depth: int

    @property
    def alpha(self) -> float:
        """GGX width."""
        return resolve(["alpha"], {"r": self.r})["alpha"]

    @property
    def picture(self) -> str:
        """The plain word that names the picture with this sphere (`MaterialConfig.picture`)."""
        return self.material if self.ior is None else f"{self.material}-ior-{self.ior:g}"

    @property
    def approximations(self) -> str:
        """Names of what stands for E, for people; those outside their domain have a star."""
        return joined({role: a.name for role, a in self.albedos.items()}, self.outside)

    def to_dict(self) -> dict[str, Any]:
        """A JSON-ready dictionary that `from_dict` reads back."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> "Sphere":
        """The inverse of `to_dict`."""
        colours = {key: None if data[key] is None else tuple(data[key]) for key in ("eta", "k", "rho")}
        albedos = {role: AlbedoCode(**fields) for role, fields in data["albedos"].items()}
        return cls(**{**data, **colours, "albedos": albedos, "outside": tuple(data["outside"])})

    def key(self, variant: str) -> str:
        """A hash of all that the picture depends on."""
        text = json.dumps([RENDERING_VERSION, variant, self.to_dict()], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:20]


def joined(names: Mapping[str, str], outside: tuple[str, ...]) -> str:
    """Names for people, by role; those of `outside` have a star."""
    return " + ".join(f"{name}*" if role in outside else name for role, name in names.items())
