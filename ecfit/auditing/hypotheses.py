"""What may have gone wrong with a table or a formula: each mistake is a change of how it is read.

A hypothesis turns the claimed reading into the one that was meant. It is right where the numbers agree with
the integral in the new reading, and with the old one only by chance. Mistakes of different slots combine.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from ecfit.auditing.reading import Reading
from ecfit.bsdf import model as registered_model
from ecfit.contract import LOBES, TRANSPORTS
from ecfit.coordinates import SPACINGS, Axis
from ecfit.errors import EcfitError

Change = Callable[[Reading], Reading]


@dataclass(frozen=True)
class Hypothesis:
    """A mistake and how to undo it.

    Attributes:
        name: the mistake in a few words: "alpha given as r".
        slot: mistakes of one slot exclude each other; they are undone in the order of `SLOTS`.
        sentence: what is then true: "the nodes named r are alpha".
        change: from the claimed reading to the one that was meant.
        same_integrals: whether the contract stays, so that trying it costs little.
    """

    name: str
    slot: str
    sentence: str
    change: Change
    same_integrals: bool = True


# In this order mistakes are undone: first how the file was read, then what its coordinates and values mean.
SLOTS = (
    "order", "direction", "spacing", "lowest", "roughness", "coordinate", "stored", "scale", "contract",
)  # fmt: skip

Forward = Callable[[np.ndarray], np.ndarray]

# Slot, coordinate as it is named, what was given, the coordinate that is meant, and how to get it from that.
_RELABELS: tuple[tuple[str, str, str, str, Forward], ...] = (
    ("roughness", "r", "alpha", "alpha", lambda x: x),
    ("roughness", "r", "alpha^2", "alpha", np.sqrt),
    ("roughness", "alpha", "r", "r", lambda x: x),
    ("roughness", "alpha", "alpha^2", "alpha", np.sqrt),
    ("coordinate", "F0", "F0^(1/2)", "F0", lambda x: x**2),
    ("coordinate", "F0", "F0^(1/4)", "F0", lambda x: x**4),
    ("coordinate", "mu", "sqrt(mu)", "mu", lambda x: x**2),
    ("coordinate", "mu", "theta / 90 degrees", "mu", lambda x: np.cos(0.5 * np.pi * x)),
    ("coordinate", "mu", "sin(theta)", "mu", lambda x: np.sqrt(np.maximum(1.0 - x * x, 0.0))),
)
# Where generators keep coordinates whose node is 0: cosines of Cycles, OSL and others, and the clamps of
# Sforza & Pellacini 2022 (mu 0.02, r 0.035) and of mobile renderers.
_LOWEST = {"mu": (1e-6, 1e-4, 1e-3, 0.01, 0.02), "r": (0.01, 0.035, 0.045, 0.089)}
# Whole numbers that stand for 1.
_SCALES = (100.0, 255.0, 65535.0)
# Options that change what is integrated and that a contract may get wrong, with the words for it. Fresnel
# models are not among them: their parameters would have to be guessed too.
_OPTIONS = {
    "masking": "a {new} table called {old}",
    "side": "a {new} table called {old}",
    "ndf": "a {new} table called {old}",
}
_LOBES = {"all": "R + T", "reflection": "R", "transmission": "T"}
# Quantities of a reflecting lobe that are taken for each other.
_QUANTITIES = {"directional-albedo": "E", "schlick-a": "A", "schlick-b": "B"}
# Nodes are taken for equally spaced within this part of a step.
_EVEN = 1e-4


def hypotheses(reading: Reading) -> list[Hypothesis]:
    """All mistakes that could have been made with a reading, cheap ones (same integrals) first."""
    cheap = (_orders, _directions, _spacings, _lowest, _relabels, _stored, _scales)
    return [h for find in (*cheap, _options, _transports, _lobes, _quantities) for h in find(reading)]


def _orders(reading: Reading) -> Iterator[Hypothesis]:
    """The dimensions of the file in another order: its flat list of numbers is dealt out again."""
    names, counts = reading.grid.names, reading.values.shape
    if not 2 <= len(names) <= 3:  # four axes have 23 other orders
        return
    for order in permutations(range(len(names))):
        if list(order) == sorted(order):
            continue
        if reading.formula and not all(_alike(reading.axes[i], reading.axes[j]) for i, j in enumerate(order)):
            continue
        shape = [counts[i] for i in order]

        def change(r: Reading, shape: list[int] = shape, order: tuple[int, ...] = order) -> Reading:
            return replace(r, values=r.values.reshape(shape).transpose(np.argsort(order)))

        meant = ", ".join(names[i] for i in order)
        if reading.formula:
            text = f"the arguments ({', '.join(names)}) are meant as ({meant})"
            yield Hypothesis("arguments swapped", "order", text, change)
        else:
            text = f"the numbers are stored in the order ({meant}), the last varying fastest"
            yield Hypothesis("axes swapped", "order", text, change)


def _alike(a: Axis, b: Axis) -> bool:
    return a.nodes.shape == b.nodes.shape and bool(np.array_equal(a.nodes, b.nodes))


def _directions(reading: Reading) -> Iterator[Hypothesis]:
    for i, axis in enumerate(reading.axes):

        def change(r: Reading, i: int = i) -> Reading:
            return replace(r, values=np.flip(r.values, i))

        if not reading.formula:
            text = f"the numbers run from the last node of {axis.name} to the first"
            yield Hypothesis(f"axis {axis.name} flipped", "direction", text, change)
        elif np.allclose(axis.nodes, 1.0 - axis.nodes[::-1], atol=1e-12):
            text = f"the argument {axis.name} is meant as 1 - {axis.name} (gloss for roughness)"
            yield Hypothesis(f"1 - {axis.name} given as {axis.name}", "direction", text, change)


def _spacings(reading: Reading) -> Iterator[Hypothesis]:
    if reading.formula:
        return
    both = {
        "texel-centre": (
            "texel-centre table read at edges",
            "at texel centres (i + 0.5) / N, not at the ends",
        ),
        "uniform": ("edge table read at texel centres", "at i / (N - 1), both ends included"),
    }
    for spacing, (name, text) in both.items():
        moved = {a.name: new for a in reading.axes if (new := _respaced(a, spacing)) is not None}
        if not moved:
            continue
        for chosen in (moved, *({n: a} for n, a in moved.items() if len(moved) > 1)):

            def change(r: Reading, chosen: dict[str, Axis] = chosen) -> Reading:
                return replace(r, axes=tuple(chosen.get(a.name, a) for a in r.axes))

            only = "" if len(chosen) == len(moved) else f" (only {next(iter(chosen))})"
            where = "" if not only else f" of {next(iter(chosen))}"
            yield Hypothesis(name + only, "spacing", f"the nodes{where} lie {text}", change)


def _respaced(axis: Axis, spacing: str) -> Axis | None:
    """The axis with its nodes at edges or at texel centres instead; None where it has neither."""
    count, found, low, high, through = len(axis), axis.spacing, axis.low, axis.high, axis.through
    if found == "clamped":
        found = "uniform"
    elif found == "given":
        through = "identity"
        for candidate, (start, end) in {"uniform": (low, high), "texel-centre": (0.0, 1.0)}.items():
            even = Axis.spaced(axis.name, count, start, end, candidate)
            if np.abs(even.nodes - axis.nominal).max() <= _EVEN * (end - start) / count:
                found, low, high = candidate, start, end
    if found == spacing or found not in ("uniform", "texel-centre") or spacing not in SPACINGS:
        return None
    return Axis.spaced(axis.name, count, low, high, spacing, through)


def _lowest(reading: Reading) -> Iterator[Hypothesis]:
    if reading.formula:
        return
    for name, ends in _LOWEST.items():
        axis = reading.axis(name)
        if axis is None or axis.nodes[0] != 0.0:
            continue
        for low in ends:
            if low >= axis.nodes[-1]:
                continue

            def change(r: Reading, name: str = name, low: float = low) -> Reading:
                axis = r.axis(name)
                if axis is None:
                    return r
                return r.with_axis(axis, Axis(name, np.maximum(axis.nodes, low), axis.nominal))

            text = f"where the node of {name} is 0, the integral was taken at {low:g}"
            yield Hypothesis(f"{name} kept at {low:g} or more", "lowest", text, change)


def _relabels(reading: Reading) -> Iterator[Hypothesis]:
    for slot, named, given, meant, forward in _RELABELS:
        axis = reading.axis(named)
        if axis is None or not (axis.nodes[0] >= 0.0 and axis.nodes[-1] <= 1.0):
            continue

        def change(r: Reading, named: str = named, meant: str = meant, forward: Forward = forward) -> Reading:
            axis = r.axis(named)
            if axis is None:
                raise EcfitError(f"no axis '{named}'")
            nodes = np.clip(forward(axis.nodes), 0.0, 1.0)
            if nodes[0] <= nodes[-1]:
                return r.with_axis(axis, Axis(meant, nodes, axis.nominal))
            values = np.flip(r.values, r.axes.index(axis))
            return replace(r.with_axis(axis, Axis(meant, nodes[::-1], axis.nominal)), values=values)

        what = "the argument" if reading.formula else "the nodes"
        verb = "is" if reading.formula else "are"
        yield Hypothesis(f"{given} given as {named}", slot, f"{what} named {named} {verb} {given}", change)


def _stored(reading: Reading) -> Iterator[Hypothesis]:
    def change(r: Reading) -> Reading:
        return replace(r, values=1.0 - r.values)

    yield Hypothesis("1 - E given as E", "stored", "the numbers are 1 minus what they are said to be", change)


def _scales(reading: Reading) -> Iterator[Hypothesis]:
    finite = reading.values[np.isfinite(reading.values)]
    if finite.size == 0 or finite.max() <= 2.0:  # what 1 - E of 100 % leaves is not above 1 either
        return
    for scale in _SCALES:

        def change(r: Reading, scale: float = scale) -> Reading:
            return replace(r, values=r.values / scale)

        yield Hypothesis(f"scale {scale:g} left out", "scale", f"the number {scale:g} stands for 1", change)


def _options(reading: Reading) -> Iterator[Hypothesis]:
    contract = reading.contract
    bsdf = registered_model(contract.model, **contract.options)
    for name, words in _OPTIONS.items():
        old = bsdf.options().get(name)
        for new in type(bsdf).option_choices().get(name, ()):
            if new != old:
                text = f"{name} is {new}, not {old}"
                yield _recontract(
                    words.format(new=new, old=old), text, options={**contract.options, name: new}
                )


def _transports(reading: Reading) -> Iterator[Hypothesis]:
    contract = reading.contract
    if not _transmits(reading) or contract.lobe == "reflection":
        return
    for new in TRANSPORTS:
        if new != contract.transport:
            lacks = new == "radiance"
            name = "missing eta^2" if lacks else "eta^2 too much"
            has = "has no" if lacks else "already has the"
            text = f"the transmitted lobe {has} factor eta^2: {new} transport, not {contract.transport}"
            yield _recontract(name, text, transport=new)


def _lobes(reading: Reading) -> Iterator[Hypothesis]:
    old = reading.contract.lobe
    if not _transmits(reading):
        return
    for new in LOBES:
        if new != old:
            name = f"{_LOBES[new]} given as {_LOBES[old]}"
            yield _recontract(name, f"the lobe is {new}, not {old}", lobe=new)


def _quantities(reading: Reading) -> Iterator[Hypothesis]:
    old = reading.contract.quantity
    if _transmits(reading) or old not in _QUANTITIES:
        return
    for new, letter in _QUANTITIES.items():
        if new != old:
            name = f"{letter} given as {_QUANTITIES[old]}"
            yield _recontract(name, f"the quantity is {new}, not {old}", quantity=new, quantity_options={})


def _transmits(reading: Reading) -> bool:
    return registered_model(reading.contract.model, **reading.contract.options).transmissive


def _recontract(name: str, sentence: str, **changes: object) -> Hypothesis:
    def change(r: Reading) -> Reading:
        return replace(r, contract=replace(r.contract, **changes))  # type: ignore[arg-type]

    return Hypothesis(name, "contract", sentence, change, same_integrals=False)
