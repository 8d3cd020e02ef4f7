"""Features: the named functions of the coordinates that structured forms are made of.

Near the corner alpha = mu = 0 an albedo depends on mu / alpha only. Each feature therefore states its order
there (alpha and mu have 1) and itself divided by rho^order, rho = alpha + mu, in the chart t = alpha / rho,
m = mu / rho = 1 - t, which is regular on the whole closed domain.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from ecfit.errors import EcfitError, unknown
from ecfit.expressions import Node, parse, power, substitute, var
from ecfit.expressions.node import inputs, replaced

# Names of the physical coordinates that features use, in the order in which forms list them.
COORDINATES = ("mu", "alpha", "F0", "ior", "diffuse_roughness", "sigma")


@dataclass(frozen=True)
class Feature:
    """A function of mu, alpha, F0, ior, diffuse_roughness or sigma.

    Attributes:
        name: how forms and configs call it.
        text: formula in the coordinates.
        order: power of rho with which it vanishes at the corner.
        scaled: formula of feature / rho^order in t, m, rho and the other coordinates; by default `text` with
            alpha = rho t, mu = rho m (order 0).
        meaning: for people.
    """

    name: str
    text: str
    order: float
    scaled: str
    meaning: str


# 1 / ior of a dielectric is (1 - s) / (1 + s), s = sqrt(F0); its critical cosine from inside
# sqrt(1 - 1 / ior^2) = 2 sqrt(s) / (1 + s).
_CRITICAL = "(2*sqrt(sqrt(F0))/(1 + sqrt(F0)))"
_G = "sqrt({mu}*{mu} + {alpha}*{alpha}*(1 - mu*mu))"
# The turn of E at the critical cosine has about the width alpha; 1e-4 keeps w smooth at alpha = 0.
_W = f"sqrt((mu - {_CRITICAL})*(mu - {_CRITICAL}) + alpha*alpha + 1e-4)"

# The Fresnel factor from inside (Walter et al. 2007, eq. 22 with the indices swapped), its kink at mu_c as
# soft as roughness makes it. cos(theta_t) is ior sqrt((mu - mu_c)(mu + mu_c)); for d = mu - mu_c stands
# h = (d + sqrt(d^2 + W)) / 2, W = alpha^2 (1 - mu^2), written without cancellation, then h^3 / (h^2 + 2 W):
# far below mu_c a rough surface passes light as alpha^4 / |d|^3 under the root, by the tail of GGX. 1e-7,
# below the square of any alpha of use, keeps the roots smooth.
_D = f"(mu - {_CRITICAL})"
_WIDTH = "(alpha*alpha*(1 - mu*mu) + 1e-7)"
_H = f"(max({_D}, 0) + 0.5*{_WIDTH}/(abs({_D}) + sqrt({_D}*{_D} + {_WIDTH})))"
_SOFT = f"({_H}*{_H}*{_H}/({_H}*{_H} + 2*{_WIDTH}))"
# cos(theta_t) / ior; 1e-20 keeps it from 0 / 0 at mu = mu_c = 0.
_REFRACTED = f"sqrt({_SOFT}*(mu + {_CRITICAL}) + 1e-20)"
_INVERSE = "((1 - sqrt(F0))/(1 + sqrt(F0)))"
# g in the place of mu: the cosine at the facets that a rough surface shows at grazing.
_FACET = _G.format(mu="mu", alpha="alpha")
_RS = f"(({_FACET} - {_REFRACTED})/({_FACET} + {_REFRACTED}))"
_RP = f"(({_INVERSE}*{_INVERSE}*{_FACET} - {_REFRACTED})/({_INVERSE}*{_INVERSE}*{_FACET} + {_REFRACTED}))"

# B_F of Fujii's Oren-Nayar divides by 1 + this times the roughness (Portsmouth et al. 2024).
FUJII = "(0.5 - 2/(3*3.141592653589793))"

FEATURES: dict[str, Feature] = {
    f.name: f
    for f in (
        Feature("alpha", "alpha", 1.0, "t", "GGX width"),
        Feature("mu", "mu", 1.0, "m", "cosine of the view angle"),
        Feature("r", "sqrt(alpha)", 0.5, "sqrt(t)", "sqrt(alpha)"),
        Feature("root_mu", "sqrt(mu)", 0.5, "sqrt(m)", "sqrt(mu)"),
        Feature("u", "1 - mu", 0.0, "", "1 - mu"),
        Feature("g", _G.format(mu="mu", alpha="alpha"), 1.0, _G.format(mu="m", alpha="t"),
                "sqrt(mu^2 + alpha^2 (1 - mu^2)), of Smith's G1 = 2 mu / (mu + g) of GGX"),
        Feature("G1", f"2*mu/(mu + {_G.format(mu='mu', alpha='alpha')})", 0.0,
                f"2*m/(m + {_G.format(mu='m', alpha='t')})", "Smith masking of GGX"),
        Feature("T", f"(mu + alpha)**2*(1 - mu*mu)/(mu + {_G.format(mu='mu', alpha='alpha')})**2", 0.0,
                f"(1 - mu*mu)/(m + {_G.format(mu='m', alpha='t')})**2", "(1 - G1) / t^2, t = alpha / rho"),
        Feature("s", "sqrt(F0)", 0.0, "", "sqrt(F0) = (ior - 1) / (ior + 1)"),
        Feature("v", "sqrt(2*sqrt(F0))", 0.0, "", "sqrt(2 sqrt(F0))"),
        Feature("F0", "F0", 0.0, "", "reflectance at normal incidence"),
        Feature("x", "ior - 1", 0.0, "", "ior - 1"),
        Feature("mu_c", _CRITICAL, 0.0, "", "critical cosine of a dielectric seen from inside"),
        Feature("w", _W, 0.0, "", "sqrt((mu - mu_c)^2 + alpha^2 + 1e-4): a soft turn at mu_c"),
        Feature("F_in", f"0.5*({_RS}*{_RS} + {_RP}*{_RP})", 0.0, "",
                "Fresnel factor of a dielectric seen from inside, its turn at mu_c as soft as alpha"),
        Feature("mu_t", "sqrt(1 - ((1 - sqrt(F0))/(1 + sqrt(F0)))**2*(1 - mu*mu))", 0.0, "",
                "cosine of the refracted ray, entering"),
        Feature("diffuse_roughness", "diffuse_roughness", 0.0, "", "roughness of Fujii's Oren-Nayar"),
        Feature("sigma", "sigma", 0.0, "", "spread of the facets' slope angle of Oren-Nayar in rad"),
        Feature("A_q", "1 - 0.5*sigma*sigma/(sigma*sigma + 0.33)", 0.0, "", "A of qualitative Oren-Nayar"),
        Feature("B_q", "0.45*sigma*sigma/(sigma*sigma + 0.09)", 0.0, "", "B of qualitative Oren-Nayar"),
        Feature("B_F", f"diffuse_roughness/(1 + {FUJII}*diffuse_roughness)", 0.0, "",
                "weight B of Fujii's Oren-Nayar: 1 - E is B times a function of mu"),
    )
}  # fmt: skip


def feature(name: str) -> Feature:
    """A feature by name. Raises `EcfitError` for an unknown one (it lists the known)."""
    if name not in FEATURES:
        raise unknown("feature", name, FEATURES)
    return FEATURES[name]


@cache
def plain(name: str) -> Node:
    """The feature as an expression of the coordinates."""
    return parse(feature(name).text, COORDINATES)


def chart() -> dict[str, Node]:
    """alpha and mu in the coordinates t and rho of the corner chart."""
    rho, t = var("rho"), var("t")
    return {"alpha": rho * t, "mu": rho * (1.0 - t)}


@cache
def scaled(name: str) -> Node:
    """feature / rho^order as an expression of t, rho and the coordinates other than alpha and mu."""
    found = feature(name)
    text = found.scaled or found.text
    node = parse(text, (*COORDINATES, "t", "m", "rho"))
    return substitute(node, {**chart(), "m": 1.0 - var("t")})


def untied(node: Node) -> Node:
    """An expression of t and rho with m, alpha and mu as inputs of their own where it forms them.

    For m = mu / rho, which 1 - t is too, but without its digits where t is near 1.
    """
    m = 1.0 - var("t")
    return replaced(node, {m: var("m"), var("rho") * var("t"): var("alpha"), var("rho") * m: var("mu")})


def coordinates_of(names: Sequence[str]) -> tuple[str, ...]:
    """The coordinates that features need, in the order of `COORDINATES`."""
    used: set[str] = set()
    for name in names:
        used |= inputs(plain(name))
    return tuple(c for c in COORDINATES if c in used)


def monomial(powers: Mapping[str, float], nodes: Mapping[str, Node]) -> Node:
    """A product of powers of features given as expressions."""
    out: Node | None = None
    for name, exponent in powers.items():
        if exponent:
            part = power(nodes[name], exponent)
            out = part if out is None else out * part
    return out if out is not None else parse("1", ())


def order(powers: Mapping[str, float]) -> float:
    """Order at the corner of a product of powers of features."""
    return sum(feature(name).order * exponent for name, exponent in powers.items())


def check_powers(powers: Mapping[str, float], where: str) -> dict[str, float]:
    """Powers of features as a dictionary of floats. Raises `EcfitError` for names and exponents unknown."""
    out = {}
    for name, exponent in dict(powers).items():
        feature(name)
        if isinstance(exponent, bool) or not isinstance(exponent, int | float) or not 0 <= exponent <= 64:
            raise EcfitError(f"{where}: the exponent of {name} must be in 0..64, got {exponent!r}")
        out[name] = float(exponent)
    return out
