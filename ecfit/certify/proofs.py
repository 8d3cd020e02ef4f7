"""Proofs about signs and ranges over the closed domain, by interval subdivision with outward rounding."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from ecfit.certify.subject import Subject
from ecfit.expressions import Node, const, value
from ecfit.expressions.bounds import smallest
from ecfit.expressions.factors import factors
from ecfit.forms import Minimum

# Single precision cannot tell a value this far beyond 1 from 1: half a unit in its last place.
SLACK = 2.0**-24
# Arguments of roots may fall below 0 by this: rounding of the enclosures.
_ROOT_SLACK = 1e-12
# Boxes spent on a whole expression before its factors are tried.
_FIRST_TRY = 40_000
# And on each of the factors: here it must end.
_FACTOR_BOXES = 400_000
# And on the ends of the range: more would only make them tighter.
_RANGE_BOXES = 50_000


@dataclass(frozen=True)
class Proof:
    """A claim about the whole closed domain.

    Attributes:
        claim: in words.
        proven: whether it is proved.
        bound: lower bound that was proved, of what the claim says is >= or > 0 (-inf: none).
        value: least value found.
        place: coordinates of that value.
    """

    claim: str
    proven: bool
    bound: float
    value: float
    place: Mapping[str, float]

    def describe(self) -> str:
        """One line."""
        found = f"least value found {self.value:.4g} at {_at(self.place)}"
        if self.proven:
            return f"{self.claim}: proved, at least {self.bound:.4g} ({found})"
        verdict = "false" if self.value < 0.0 else "not proved"
        return f"{self.claim}: {verdict}, lower bound {self.bound:.4g} ({found})"

    def to_dict(self) -> dict[str, Any]:
        """A JSON-ready dictionary."""
        return asdict(self)


def divisors(subject: Subject) -> tuple[Proof, ...]:
    """That no divisor of the expression vanishes; each is taken with the sign that it has at the centre."""
    centre = {n: np.float64(0.5 * (low + high)) for n, (low, high) in subject.domain.box.items()}
    out = []
    for name, node, _ in subject.divisors:
        sign = 1.0 if not subject.domain.box or value(node, centre) >= 0.0 else -1.0
        found = subject.smallest(node if sign > 0.0 else -node)
        out.append(_proof(f"{name if sign > 0.0 else '-' + name} > 0", found.bound > 0.0, found, subject))
    return tuple(out)


def defined(subject: Subject) -> tuple[Proof, ...]:
    """That every root and logarithm is of a number for which it is real."""
    out = []
    for node in subject.roots:
        found = subject.smallest(node, enough=-0.5 * _ROOT_SLACK)
        out.append(_proof("argument of a root >= 0", found.bound >= -_ROOT_SLACK, found, subject))
    for node in subject.logarithms:
        found = subject.smallest(node, enough=math.nextafter(0.0, 1.0))
        out.append(_proof("argument of a logarithm > 0", found.bound > 0.0, found, subject))
    return tuple(out)


def floors(subject: Subject, proofs: tuple[Proof, ...]) -> dict[Node, float]:
    """The divisors' proved bounds with their signs, for `Subject.floors`."""
    out: dict[Node, float] = {}
    for (_, node, _), proof in zip(subject.divisors, proofs, strict=True):
        out[node] = -proof.bound if proof.claim.startswith("-") else proof.bound
    return out


def _proof(claim: str, proven: bool, found: Minimum, subject: Subject) -> Proof:
    return Proof(claim, bool(proven), found.bound, found.value, subject.place(found.place))


class Ceiling(NamedTuple):
    """What values cannot exceed: in words, and as an expression of the coordinates."""

    name: str
    node: Node


@dataclass(frozen=True)
class Range:
    """Values over the whole closed domain.

    Attributes:
        low, high: proven ends (infinite where nothing is proved).
        least, greatest: extreme values found, with their places.
        ceiling: what the quantity cannot exceed, in words: "1", "ior^2"; empty: nothing known.
        room: proven lower bound of ceiling - value.
        excess: largest value - ceiling found (-inf without a ceiling), with its place.
        lower, upper: how value >= 0 and value <= ceiling were proved; empty where they were not.
        identity: largest |1 - value - shared x deficit|, or |value - shared x surplus|, at random points,
            where that was used.
    """

    low: float
    high: float
    least: float
    least_place: Mapping[str, float]
    greatest: float
    greatest_place: Mapping[str, float]
    ceiling: str
    room: float
    excess: float
    excess_place: Mapping[str, float]
    lower: str
    upper: str
    identity: float | None

    @property
    def proven(self) -> bool:
        """Whether 0 <= value <= ceiling is proved (to `SLACK`); without a ceiling, that values are finite."""
        above = self.room >= -SLACK if self.ceiling else bool(np.isfinite(self.high))
        return self.low >= -SLACK and above

    @property
    def faults(self) -> list[str]:
        """What is wrong with the range, or not proved; one line each."""
        out = []
        if self.least < -SLACK:
            out.append(f"values fall below 0, by {-self.least:.3g} at {_at(self.least_place)}")
        elif self.low < -SLACK:
            out.append(f"value >= 0 is not proved (though no value below was found): >= {self.low:.3g} is")
        if self.ceiling and self.excess > SLACK:
            out.append(f"values exceed {self.ceiling}, by {self.excess:.3g} at {_at(self.excess_place)}")
        elif self.ceiling and self.room < -SLACK:
            out.append(f"value <= {self.ceiling} is not proved (though no value above was found)")
        elif not self.ceiling and not np.isfinite(self.high):
            out.append("no upper bound of the values is proved")
        return out

    def describe(self) -> list[str]:
        """A few lines."""
        out = [f"values: proved to lie in [{self.low:.6g}, {self.high:.9g}]"]
        out += [f"  {end}" for end in (self.lower, self.upper) if end]
        if self.proven and (self.low < 0.0 or (self.ceiling and self.room < 0.0)):
            out.append(
                f"  (outside [0, {self.ceiling}] by less than 2^-24, which single precision cannot tell)"
            )
        return out + [f"  {fault}" for fault in self.faults]

    def to_dict(self) -> dict[str, Any]:
        return asdict(self)


def _at(place: Mapping[str, float]) -> str:
    return ", ".join(f"{k} = {v:.4g}" for k, v in place.items())


def value_range(subject: Subject, ceiling: Ceiling | None, seed: int) -> Range:
    """Bounds of the value, by subdivision and by the structure of the form.

    Args:
        subject: its divisors must have been proved not to vanish.
        ceiling: what the quantity cannot exceed, if known.
        seed: of the points at which the identities with deficit and surplus are checked.
    """
    below = subject.smallest(subject.value, limit=_RANGE_BOXES)
    above = subject.smallest(-subject.value, limit=_RANGE_BOXES)
    low, high, lower, upper = below.bound, -above.bound, "", ""
    checked: list[float] = []

    def product(name: str, side: Node) -> str:
        """How `side` is proved >= 0 as the product of what the form holds; "" where it is not."""
        if name not in subject.held:
            return ""
        shared, rest = subject.held[name]
        checked.append(_identity(subject, side, shared * rest, seed))
        # Near 0 / 0 the two sides differ by rounding: 1e-9 is far above it, far below any coefficient.
        known = checked[-1] < 1e-9 and nonnegative(shared, subject)
        return nonnegative(rest, subject) if known else ""

    if subject.parts:
        ends = _by_parts(subject, seed)
        if ends[0] > low:
            low, lower = ends[0], ">= 0 by the ranges of its parts" if ends[0] >= 0.0 else ""
        high = min(high, ends[1])
    if lower:
        pass
    elif low >= 0.0:
        lower = ">= 0 by subdivision"
    elif below.value >= -SLACK and (how := product("surplus", subject.value)):
        low, lower = 0.0, f">= 0 exactly: the value is a product >= 0 times a surplus >= 0 ({how})"
    elif below.value >= -SLACK and (how := nonnegative(subject.value, subject)):
        low, lower = 0.0, f">= 0: {how}"
    room, excess, place = -np.inf, -np.inf, above.place
    if ceiling is not None and ceiling.node is const(1.0):
        room, excess = 1.0 - high, -above.value - 1.0
        if how := product("deficit", 1.0 - subject.value):
            upper = f"<= 1 exactly: 1 - value is a product >= 0 times a deficit >= 0 ({how})"
        if (
            not upper
            and room < 0.0
            and excess <= SLACK
            and (how := nonnegative(1.0 - subject.value, subject))
        ):
            upper = f"<= 1: {how}"
        if upper:
            room, high = max(room, 0.0), min(high, 1.0)
        elif room >= 0.0:
            upper = "<= 1 by subdivision"
    elif ceiling is not None:
        found = subject.smallest(ceiling.node - subject.value)
        room, excess, place = found.bound, -found.value, found.place
        upper = f"<= {ceiling.name} by subdivision" if room >= 0.0 else ""
    return Range(
        low=low,
        high=high,
        least=below.value,
        least_place=subject.place(below.place),
        greatest=-above.value,
        greatest_place=subject.place(above.place),
        ceiling="" if ceiling is None else ceiling.name,
        room=room,
        excess=excess,
        excess_place=subject.place(place),
        lower=lower,
        upper=upper,
        identity=max(checked, default=None),
    )


def _by_parts(subject: Subject, seed: int) -> tuple[float, float]:
    """Bounds of a composed value from the proved ranges of its parts, each taken by itself."""
    box = {}
    for name, part in subject.parts.items():
        own = value_range(part, Ceiling("1", const(1.0)), seed)
        box[name] = (own.low, own.high)
    if subject.text is None or not np.all(np.isfinite([*box.values()])):
        return -np.inf, np.inf
    return smallest(subject.text, box).bound, -smallest(-subject.text, box).bound


def nonnegative(node: Node, subject: Subject) -> str:
    """How an expression is proved to be >= 0 on the domain: in words, or "" where it is not proved."""
    found = subject.smallest(node, enough=0.0, limit=_FIRST_TRY)
    if found.bound >= 0.0:
        return "by subdivision"
    if found.value < 0.0:
        return ""
    known: dict[Node, bool] = {}

    def positive(base: Node) -> bool:
        if base not in known:
            known[base] = subject.smallest(base, enough=0.0, limit=_FACTOR_BOXES).bound >= 0.0
        return known[base]

    parts = factors(node, positive)
    if all(positive(base) for base, exponent in parts.items() if exponent % 2.0):
        return f"as a product of {len(parts)} factors, each by subdivision"
    return ""


def _identity(subject: Subject, side: Node, product: Node, seed: int) -> float:
    """Largest |side - product| at points of the interior."""
    rng = np.random.default_rng(seed)
    points = {n: rng.uniform(low, high, 2000) for n, (low, high) in subject.domain.box.items()}
    constraint = subject.domain.constraint
    if constraint is not None and subject.charted:
        inside = ~constraint({n: (p, p) for n, p in points.items()})
        points = {n: p[inside] for n, p in points.items()}
    return float(np.max(np.abs(value(side, points) - value(product, points)), initial=0.0))
