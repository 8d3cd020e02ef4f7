"""The typed form of a furnace's TOML file: which spheres are rendered, what compensates them. No JAX here."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from ecfit.config.study import Fault, Word, _Section, read_checked

Reflectance = Annotated[float, Field(ge=0.0, le=1.0)]
Colour = Annotated[
    list[Annotated[float, Field(ge=0.0, allow_inf_nan=False)]], Field(min_length=3, max_length=3)
]
Names = Annotated[list[str], Field(min_length=1)]
Pixels = Annotated[int, Field(ge=8, le=2048)]
Samples = Annotated[int, Field(ge=4, le=1_000_000)]

# The albedos that a row names, and what each normalises.
ROLES = ("conductor", "glossy", "entering", "leaving")
# Model -> the albedos that its compensation takes.
NEEDS = {
    "conductor": ("conductor",),
    "glossy": ("conductor", "glossy"),
    "thin-dielectric": ("conductor",),
    "dielectric": ("entering", "leaving"),
}


class RowConfig(_Section):
    """One row of spheres: no compensation, small tables, or fits by name."""

    name: Annotated[
        str, Field(min_length=1, max_length=40, pattern=r"^[^|\n]+$", description="written beside the row")
    ]
    table: Annotated[
        int | None, Field(ge=2, le=256, description="look-up tables with so many nodes a coordinate")
    ] = None
    conductor: Annotated[Names | None, Field(description="fits of E_ss, the albedo without Fresnel")] = None
    glossy: Annotated[Names | None, Field(description="fits of E_spec, the compensated layer")] = None
    entering: Annotated[Names | None, Field(description="fits of R + T of a dielectric from outside")] = None
    leaving: Annotated[Names | None, Field(description="fits of R + T from inside")] = None

    @model_validator(mode="after")
    def _one_kind(self) -> "RowConfig":
        if self.table is not None and any(getattr(self, role) is not None for role in ROLES):
            raise ValueError("give either table or names of fits")
        return self

    @property
    def compensates(self) -> bool:
        """Whether anything is put back."""
        return self.table is not None or any(getattr(self, role) is not None for role in ROLES)


class MaterialConfig(_Section):
    """One material: a picture for each index of refraction. Several may share a name where these differ."""

    name: Annotated[Word, Field(description="of its pictures")]
    model: Annotated[
        Literal["conductor", "glossy", "thin-dielectric", "dielectric"],
        Field(description="what it is made of"),
    ]
    light: Annotated[
        Literal["constant", "studio"],
        Field(description="constant: the furnace; studio: lamps and a sky, to look at"),
    ] = "constant"
    ior: Annotated[
        list[Annotated[float, Field(gt=1.0, le=10.0)]] | None,
        Field(min_length=1, description="indices of refraction"),
    ] = None
    eta: Annotated[Colour | None, Field(description="conductor: refractive index for red, green, blue")] = (
        None
    )
    k: Annotated[Colour | None, Field(description="conductor: extinction for red, green, blue")] = None
    rho: Annotated[
        list[Reflectance] | None,
        Field(min_length=3, max_length=3, description="glossy: reflectance of the base, white without"),
    ] = None
    pixels: Annotated[Pixels | None, Field(description="instead of the furnace's")] = None
    samples: Annotated[Samples | None, Field(description="instead of the furnace's")] = None

    def picture(self, ior: float | None) -> str:
        """The plain word that names the picture of one index of refraction."""
        return self.name if ior is None else f"{self.name}-ior-{ior:g}"

    @model_validator(mode="after")
    def _belongs(self) -> "MaterialConfig":
        if (self.ior is None) != (self.model == "conductor"):
            raise ValueError("give ior, but not for a conductor, which takes eta and k (white without)")
        if (self.eta is None) != (self.k is None) or (self.eta is not None and self.model != "conductor"):
            raise ValueError("eta and k go together, and belong to a conductor")
        if self.model != "glossy" and self.rho is not None:
            raise ValueError("rho belongs to the model 'glossy'")
        return self


class FurnaceConfig(_Section):
    """All pictures of one furnace: materials x roughness x rows."""

    name: Annotated[Word, Field(description="name of its folder in results")]
    r: Annotated[
        list[Annotated[float, Field(ge=0.05, le=1.0)]],
        Field(min_length=1, max_length=12, description="sqrt(alpha) of the spheres, from left to right"),
    ]
    pixels: Annotated[Pixels, Field(description="width and height of a sphere's picture")] = 96
    samples: Annotated[Samples, Field(description="paths of each pixel, over all seeds")] = 512
    seeds: Annotated[
        int, Field(ge=2, le=64, description="independent renders, whose scatter is the estimate of the noise")
    ] = 8
    candidates: Annotated[
        int,
        Field(ge=1, le=256, description="directions sampled at a scattering, one of which the path takes"),
    ] = 8
    depth: Annotated[int, Field(ge=1, le=100_000, description="scatterings after which a path is cut")] = 4096
    rows: Annotated[list[RowConfig], Field(min_length=1, max_length=8, description="from top to bottom")]
    materials: Annotated[list[MaterialConfig], Field(min_length=1, description="what is rendered")]

    @model_validator(mode="after")
    def _once(self) -> "FurnaceConfig":
        for value in self.r:
            if self.r.count(value) > 1:
                raise ValueError(f"r has {value:g} twice: a column each")
        return self

    @model_validator(mode="after")
    def _whole_seeds(self) -> "FurnaceConfig":
        for samples in (self.samples, *(m.samples for m in self.materials)):
            if samples is not None and samples % self.seeds:
                raise ValueError(f"samples must be a multiple of seeds, {self.seeds}: got {samples}")
        return self


def read_furnace(path: str | Path) -> FurnaceConfig:
    """Read and check the file of a furnace. Raises `EcfitError` as `read_config` does."""
    return read_checked(path, FurnaceConfig, _cross_check, "configs/furnace.toml")


def _cross_check(config: FurnaceConfig) -> list[Fault]:
    """Faults between sections: names used twice, rows that lack what a material needs."""
    faults: list[Fault] = []
    names = [row.name for row in config.rows]
    for i, name in enumerate(names):
        if name in names[:i]:
            faults.append((("rows", i, "name"), f"the name '{name}' is used twice"))
    taken: set[str] = set()
    for i, material in enumerate(config.materials):
        for picture in map(material.picture, material.ior or [None]):
            if picture in taken:
                faults.append((("materials", i, "name"), f"two materials make the picture '{picture}'"))
            taken.add(picture)
    for i, row in enumerate(config.rows):
        if row.table is not None or not row.compensates:
            continue
        for material in config.materials:
            for role in NEEDS[material.model]:
                if getattr(row, role) is None:
                    message = (
                        f"the row '{row.name}' has no {role}, which the material '{material.name}' needs"
                    )
                    faults.append((("rows", i), message))
    return faults
