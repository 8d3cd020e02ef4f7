"""Layouts by name: how renderers store albedo tables, as data.

What stands here was read in the consumer's own source, which `source` names; what could not be is said in
`unsure`. Other people's formats change: `ecfit check FILE --layout NAME` tells whether one still fits.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ecfit.coordinates import Axis
from ecfit.errors import EcfitError, unknown


@dataclass(frozen=True)
class Nodes:
    """One axis of a layout: coordinate = low + (high - low) t^power at spaced t in [0, 1].

    `clip`: t is kept within these ends where the integral is taken; the table is read as if it were not.
    """

    name: str
    count: int
    spacing: str = "uniform"
    low: float = 0.0
    high: float = 1.0
    power: int = 1
    clip: tuple[float, float] = (0.0, 1.0)

    def axis(self, count: int | None = None) -> Axis:
        """The axis, with another number of nodes if given. Raises `EcfitError` for fewer than 2."""
        count = self.count if count is None else count
        through = {1: "identity", 2: "square", 4: "fourth-power"}.get(self.power)
        unit = (self.low, self.high) == (0.0, 1.0)
        if through is not None and self.clip == (0.0, 1.0) and (unit or self.power == 1):
            return Axis.spaced(self.name, count, self.low, self.high, self.spacing, through)
        t = Axis.spaced("t", count, spacing=self.spacing).nodes
        clipped = self._at(np.clip(t, *self.clip))
        spacing = "given" if self.clip == (0.0, 1.0) else "clamped"
        return Axis(self.name, clipped, self._at(t), spacing, low=self.low, high=self.high)

    def _at(self, t: np.ndarray) -> np.ndarray:
        return self.low + (self.high - self.low) * t**self.power

    def describe(self) -> str:
        """One line: `F0 = t^4, 16 nodes at t = i / 15`."""
        place = f"i / {self.count - 1}" if self.spacing == "uniform" else f"(i + 0.5) / {self.count}"
        power = "t" if self.power == 1 else f"t^{self.power}"
        span = (
            power
            if (self.low, self.high) == (0.0, 1.0)
            else f"{self.low:g} + {self.high - self.low:g} {power}"
        )
        kept = "" if self.clip == (0.0, 1.0) else f", t kept within [{self.clip[0]:g}, {self.clip[1]:g}]"
        return f"{self.name} = {span}, {self.count} nodes at t = {place}{kept}"


@dataclass(frozen=True)
class Channel:
    """One number of an entry: its name in the file, and the quantity it holds (None: any)."""

    name: str = ""
    quantity: str | None = None


@dataclass(frozen=True)
class Piece:
    """One of several tables that follow each other in a file.

    `options`: settings of the model that it is of; `backwards`: axes that it stores from last node to first.
    """

    name: str = ""
    options: Mapping[str, str] = field(default_factory=dict)
    backwards: tuple[str, ...] = ()


@dataclass(frozen=True)
class Layout:
    """How a consumer stores a table.

    Attributes:
        name: of the layout.
        about: what it is for.
        axes: from the slowest to the one that varies fastest; none: the table's own.
        source: where the convention is from.
        unsure: what is not known of it.
        stored: "E" or "1-E".
        number: a name of `ecfit.tables.numbers.NUMBERS`.
        ending: of the files that the consumer takes.
        channels: of one entry, interleaved.
        pieces: tables that follow each other.
        backwards: axes stored from last node to first.
        model, options: what the consumer's shading code evaluates.
    """

    name: str
    about: str
    axes: tuple[Nodes, ...]
    source: str
    unsure: str = ""
    stored: str = "E"
    number: str = "float32"
    ending: str = ".h"
    channels: tuple[Channel, ...] = (Channel(),)
    pieces: tuple[Piece, ...] = (Piece(),)
    backwards: tuple[str, ...] = ()
    model: str = "unknown"
    options: Mapping[str, str] = field(default_factory=dict)

    def order(self, piece: Piece) -> list[str]:
        """Names of the axes as `ecfit.read_table` takes them: "-mu" runs backwards."""
        back = {*self.backwards, *piece.backwards}
        return [f"-{a.name}" if a.name in back else a.name for a in self.axes]

    def piece(self, name: str | None) -> Piece:
        """The piece of that name, or the only one. Raises `EcfitError`."""
        if name is None and len(self.pieces) == 1:
            return self.pieces[0]
        for piece in self.pieces:
            if piece.name == name:
                return piece
        if len(self.pieces) == 1:
            raise EcfitError(f"layout '{self.name}' has no piece '{name}', it is one table: leave piece out")
        names = ", ".join(p.name for p in self.pieces)
        raise EcfitError(f"layout '{self.name}': which piece? Expected one of {names}")

    def channel(self, name: str | None) -> int:
        """The index of the channel of that name, the first by default. Raises `EcfitError`."""
        names = [c.name for c in self.channels]
        if name is None or len(names) == 1:
            return 0
        if name not in names:
            raise unknown("channel", name, names)
        return names.index(name)

    def describe(self) -> list[str]:
        """Lines for people."""
        out = [f"{self.name}: {self.about}"]
        out += [f"  {a.describe()}" for a in self.axes] or ["  the axes of the table"]
        order = ", ".join(self.order(Piece()))
        channels = ", ".join(f"{c.name} = {c.quantity}" for c in self.channels if c.name)
        kept = [f"*{self.ending}", f"{self.number} of {self.stored}"]
        kept += [f"order ({order}), the last varies fastest"] if self.axes else []
        kept += [f"channels {channels}"] if channels else []
        kept += [f"pieces {', '.join(p.name for p in self.pieces)}"] if len(self.pieces) > 1 else []
        out.append(f"  {'; '.join(kept)}")
        out.append(f"  source: {self.source}")
        return out + ([f"  not certain: {self.unsure}"] if self.unsure else [])


_CORRELATED = dict(masking="height-correlated")
_RG = (Channel("R", "schlick-a"), Channel("G", "schlick-b"))
# Cycles integrates at 1e-4 where a node is 0, and at z = 0.99 where it is 1.
_CYCLES = (1e-4, 1.0)
# OSL keeps cosines at 1e-6 or more: in t, where mu = t^2, at 1e-3.
_OSL_COSINE = Nodes("mu", 16, power=2, clip=(1e-3, 1.0))

LAYOUTS: dict[str, Layout] = {
    layout.name: layout
    for layout in (
        Layout(
            "plain",
            "the table's own axes, order and spacing, for whoever reads NPY, CSV, EXR, raw numbers or C",
            (),
            "ecfit",
            ending=".npy",
            number="float64",
        ),
        Layout(
            "cycles",
            "Cycles' ggx_E: E1 of the GGX reflection lobe",
            (Nodes("mu", 32, clip=_CYCLES), Nodes("r", 32, clip=_CYCLES)),
            "Blender 4.x, intern/cycles: app/cycles_precompute.cpp (nodes, order) and kernel/util/"
            "lookup_table.h (nodes at i / (N - 1)); roughness is sqrt(alpha) in bsdf_microfacet.h",
            model="conductor",
            options=_CORRELATED,
        ),
        Layout(
            "cycles-average",
            "Cycles' ggx_Eavg: the average albedo of the GGX reflection lobe",
            (Nodes("r", 32, clip=_CYCLES),),
            "as cycles",
            channels=(Channel("", "average-albedo"),),
            model="conductor",
            options=_CORRELATED,
        ),
        Layout(
            "cycles-glass",
            "Cycles' ggx_glass_E: R + T of a rough dielectric seen from outside",
            (
                Nodes("F0", 16, power=4, clip=(1e-4, 0.99)),
                Nodes("mu", 16, clip=_CYCLES),
                Nodes("r", 16, clip=_CYCLES),
            ),
            "as cycles; z = sqrt(|ior - 1| / (ior + 1)) = F0^(1/4)",
            "that its refracted samples weigh as energy (no eta^2 lost) is read from the sampler's weights",
            model="dielectric",
            options=dict(masking="height-correlated", side="entering"),
        ),
        Layout(
            "cycles-glass-inv",
            "Cycles' ggx_glass_inv_E: the same seen from inside",
            (
                Nodes("F0", 16, power=4, clip=(1e-4, 0.99)),
                Nodes("mu", 16, clip=_CYCLES),
                Nodes("r", 16, clip=_CYCLES),
            ),
            "as cycles-glass; F0 is that of the denser side",
            "as cycles-glass",
            model="dielectric",
            options=dict(masking="height-correlated", side="leaving"),
        ),
        Layout(
            "osl",
            "OSL's MiniMicrofacetGGX (libbsdl): 1 - E1 of the GGX reflection lobe",
            (Nodes("r", 16), _OSL_COSINE),
            "OpenShadingLanguage, src/libbsdl: src/genluts.cpp (order, 1 - E), microfacet_tools_decl.h "
            "(mu = max(t^2, 1e-6), alpha = roughness^2) and microfacet_tools_impl.h (correlated G2)",
            stored="1-E",
            model="conductor",
            options=_CORRELATED,
        ),
        Layout(
            "osl-dielectric-front",
            "OSL's DielectricFront (libbsdl): 1 - (R + T) of a rough dielectric seen from outside",
            (
                Nodes("ior", 32, low=1.001, high=5.0, power=2),
                Nodes("r", 16),
                Nodes("mu", 16, clip=(1e-6, 1.0)),
            ),
            "OpenShadingLanguage, src/libbsdl: src/genluts.cpp, SPI/bsdf_dielectric_decl.h and "
            "SPI/bsdf_dielectric_impl.h (ior = 1.001 + 3.999 t^2)",
            "that its sample weights are energies is read from the sampler; there alpha is at least 1e-5",
            stored="1-E",
            model="dielectric",
            options=dict(masking="height-correlated", side="entering"),
        ),
        Layout(
            "osl-dielectric-back",
            "OSL's DielectricBack (libbsdl): the same seen from inside",
            (
                Nodes("ior", 32, low=1.001, high=5.0, power=2),
                Nodes("r", 16),
                Nodes("mu", 16, clip=(1e-6, 1.0)),
            ),
            "as osl-dielectric-front",
            "as osl-dielectric-front",
            stored="1-E",
            model="dielectric",
            options=dict(masking="height-correlated", side="leaving"),
        ),
        Layout(
            "openpbr-bsdf",
            "openpbr-bsdf's ideal metal: 1 - E1 of the GGX reflection lobe",
            (Nodes("r", 32), Nodes("mu", 32)),
            "adobe/openpbr-bsdf, impl/data/openpbr_energy_array_access.h (order, 65535) and "
            "impl/openpbr_microfacet_multiple_scattering_data.h (index = sqrt(alpha) 31, cos_theta 31)",
            "which masking its tables were made with",
            stored="1-E",
            number="uint16",
            model="conductor",
            options=_CORRELATED,
        ),
        Layout(
            "openpbr-bsdf-average",
            "openpbr-bsdf's ideal metal: 1 - the average albedo",
            (Nodes("r", 32),),
            "as openpbr-bsdf",
            "as openpbr-bsdf",
            stored="1-E",
            number="uint16",
            channels=(Channel("", "average-albedo"),),
            model="conductor",
            options=_CORRELATED,
        ),
        Layout(
            "openpbr-bsdf-dielectric",
            "openpbr-bsdf's ideal dielectric: 1 - (R + T); ior 1/2.5 ... 1 and 1 ... 2.5, 16 nodes each",
            (Nodes("ior", 16, low=1.0, high=2.5), Nodes("r", 32), Nodes("mu", 32)),
            "as openpbr-bsdf, openpbr_ior_to_exact_index: first half 1 / ior backwards, second half ior",
            "masking and transport of its tables",
            stored="1-E",
            number="uint16",
            pieces=(
                Piece("leaving", dict(side="leaving"), ("ior",)),
                Piece("entering", dict(side="entering")),
            ),
            model="dielectric",
            options=_CORRELATED,
        ),
        Layout(
            "three",
            "three.js' DFG_LUT: A and B of E = F0 A + F90 B in halves, roughness along a row",
            (Nodes("mu", 16, "texel-centre"), Nodes("r", 16, "texel-centre")),
            "three.js r181 and later, src/renderers/shaders/DFGLUTData.js (16 x 16, RG16F) and its look-up "
            "texture2D(dfgLUT, vec2(roughness, dotNV)); alpha = roughness^2",
            number="float16",
            channels=_RG,
            model="conductor",
            options=_CORRELATED,
        ),
        Layout(
            "filament",
            "Filament's DFG: B and A + B of E = F0 A + F90 B in halves, cosine along a row",
            (Nodes("r", 128, "texel-centre"), Nodes("mu", 128, "texel-centre")),
            "google/filament, libs/ibl/src/CubemapIBL.cpp (DFV_Multiscatter: x = B, y = A + B; roughness = "
            "coord^2) and tools/cmgen (RG16F, rows in GL order)",
            "cmgen itself integrates rows at (i + 1.5) / N, one texel rougher than the sampler reads them; "
            "here they are at (i + 0.5) / N",
            number="float16",
            channels=(Channel("R", "schlick-b"), Channel("G", "directional-albedo")),
            model="conductor",
            options=_CORRELATED,
        ),
        Layout(
            "split-sum",
            "the split-sum table of course notes and engines: A in R, B in G, cosine along a row",
            (Nodes("r", 128, "texel-centre"), Nodes("mu", 128, "texel-centre")),
            "Karis 2013, Real Shading in Unreal Engine 4: EnvBRDF.Sample(float2(Roughness, NoV)), and its "
            "many copies, which mostly have float2(NoV, Roughness)",
            "each engine's order, direction of rows and masking (Godot, Bevy, ...): look at its sampler",
            number="float16",
            ending=".exr",
            channels=_RG,
            model="conductor",
            options=_CORRELATED,
        ),
        Layout(
            "enterprise-pbr",
            "Enterprise PBR's GGX_E: E1 of the metallic lobe",
            (Nodes("alpha", 32, "texel-centre"), Nodes("mu", 32, "texel-centre")),
            "Enterprise PBR Shading Model 2019x: tables of 32 x 32, in the repository as res/GGX_E.exr",
            "the order of its axes, and alpha rather than sqrt(alpha) (its fits are of alpha); texel centres "
            "by its base layer's files, which are named F0 = 0.03, 0.09, ... 0.97 = (i + 0.5) / 16",
            ending=".exr",
            model="conductor",
            options=_CORRELATED,
        ),
        Layout(
            "mitsuba",
            "an image for Mitsuba's bitmap texture (raw, bilinear, clamp): u = mu, v = r",
            (Nodes("r", 64, "texel-centre"), Nodes("mu", 64, "texel-centre")),
            "measured with Mitsuba 3.9.1 (docs/tables.md): texel centres, first row at the low end of v",
            ending=".exr",
        ),
        Layout(
            "yocto",
            "rows of numbers for Yocto/GL's look-up (Sforza & Pellacini 2022): nodes at i / (N - 1)",
            (Nodes("r", 32), Nodes("mu", 32)),
            "Sforza & Pellacini 2022, section 3: tables of 32 x 32 over (r, mu), linspace(0, 1)",
            "the order of their axes, and that their integrals were clamped (docs/reproducing-the-paper.md)",
            ending=".csv",
            number="float64",
        ),
    )
}


def layout(name: str | Layout) -> Layout:
    """A layout by its name. Raises `EcfitError` for an unknown one."""
    if isinstance(name, Layout):
        return name
    if not isinstance(name, str) or name not in LAYOUTS:
        raise unknown("layout", name, LAYOUTS)
    return LAYOUTS[name]
