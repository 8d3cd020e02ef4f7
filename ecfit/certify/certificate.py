"""`Certificate`: what was proved and measured of an approximation, as data and as text."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from ecfit.certify.narrow import Drift
from ecfit.certify.proofs import Proof, Range
from ecfit.certify.truth import SampledErrors
from ecfit.errors import EcfitError


@dataclass(frozen=True)
class Certificate:
    """The result of `certify`.

    Attributes:
        name: of the approximation.
        domain: closed range of each coordinate.
        charted: whether the proofs are in the corner chart.
        divisors: proofs that no divisor vanishes.
        defined: proofs that roots and logarithms are real.
        values: the proven range of the values, or None where a divisor may vanish.
        at_corner: the value as evaluated at alpha = mu = 0, where the form is 0 / 0 by itself.
        single_bound: proven bound of the rounding error in single precision; infinite or None: none.
        single_place: where it is largest, or unbounded.
        single, single_hard: single precision measured on the sample, and near edges and the corner.
        half, half_hard, half_chart: half precision measured likewise; half_chart is the form in t, m, rho on
            both sets of points.
        sampling: the rule of the sample.
        truth_tolerance: of the integrals.
        errors, corner_errors: errors against the model, on the sample and towards r = 0 and mu = 0.
        no_truth: why there are no such errors.
        half_errors: errors on the sample of the form evaluated in half precision: what was measured of the
            form and of its rounding, together.
    """

    name: str
    domain: Mapping[str, tuple[float, float]]
    charted: bool
    divisors: tuple[Proof, ...]
    defined: tuple[Proof, ...]
    values: Range | None
    at_corner: float | None
    single_bound: float | None
    single_place: Mapping[str, float]
    single: Drift
    single_hard: Drift
    half: Drift
    half_hard: Drift
    half_chart: Drift | None
    sampling: Mapping[str, Any]
    truth_tolerance: float
    errors: SampledErrors | None
    corner_errors: SampledErrors | None
    no_truth: str = ""
    half_errors: SampledErrors | None = None

    @property
    def refusals(self) -> list[str]:
        """Why the approximation is not certified; empty where it is."""
        out = [proof.describe() for proof in (*self.divisors, *self.defined) if not proof.proven]
        if self.values is not None:
            out += self.values.faults
        for drift in (self.single, self.single_hard):
            if drift.not_finite:
                out.append(f"single precision: {drift.describe()}")
        return out

    @property
    def certified(self) -> bool:
        """Proved: no divisor vanishes, 0 <= value <= ceiling; measured: single precision finite."""
        return not self.refusals

    def describe(self) -> list[str]:
        """Lines for people: the verdict, what is proved, what is measured."""
        verdict = "certified" if self.certified else "NOT CERTIFIED"
        where = ", ".join(f"{k} in [{low:g}, {high:g}]" for k, (low, high) in self.domain.items())
        out = [f"{self.name}: {verdict}"]
        out += [f"  refused: {reason}" for reason in self.refusals]
        out.append(f"proved, on the closed domain {where}" + _CHART * self.charted)
        out += [f"  {line}" for line in _proof_lines(self.divisors)]
        if self.defined and all(p.proven for p in self.defined):
            out.append(f"  arguments of {len(self.defined)} roots and logarithms in their domain: proved")
        if not self.divisors:
            out.append("  no division: no poles")
        if self.values is None:
            out.append("  values: nothing, as a divisor may vanish")
        else:
            out += [f"  {line}" for line in self.values.describe()]
        if self.at_corner is not None:
            out.append(f"  at alpha = mu = 0 the form is 0 / 0; evaluated, it is {self.at_corner:.9g}")
        bound = float("inf") if self.single_bound is None else self.single_bound
        text = f"at most {bound:.3g}" if bound < float("inf") else "no bound"
        at = ", ".join(f"{k} = {v:.4g}" for k, v in self.single_place.items())
        out.append(f"  rounding error in single precision: {text}" + (f" (worst near {at})" if at else ""))
        out.append("measured at random points: samples, not proofs")
        if self.errors is None:
            out.append(f"  error against the model: not measured: {self.no_truth}")
        else:
            out.append(f"  error against the model, integrated to {self.truth_tolerance:g}:")
            out.append(f"    {self.errors.describe()}")
        if self.corner_errors is not None:
            out.append("  the same towards r = 0 and mu = 0, outside that sample:")
            out.append(f"    {self.corner_errors.describe()}")
        if self.half_errors is not None:
            out.append(f"  the same sample, all in half precision: {self.half_errors.short()}")
        rows = [("single precision", self.single), ("  near edges and corner", self.single_hard),
                ("half precision", self.half), ("  near edges and corner", self.half_hard)]  # fmt: skip
        if self.half_chart is not None:
            rows.append(("half precision in t, m, rho, everywhere", self.half_chart))
        out += [f"  {label}: {drift.describe()}" for label, drift in rows]
        return out

    def to_dict(self) -> dict[str, Any]:
        """A JSON-ready dictionary that `from_dict` reads back; infinities become null in a file."""
        return {
            **asdict(self),
            "domain": {k: list(v) for k, v in self.domain.items()},
            "certified": self.certified,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> "Certificate":
        """The inverse of `to_dict`. Raises `EcfitError` for anything else."""
        try:
            given = {k: v for k, v in data.items() if k != "certified"}
            for key, kind in _NESTED.items():
                if given.get(key) is not None:
                    given[key] = kind(**_numbers(kind, given[key]))
            for key in ("divisors", "defined"):
                given[key] = tuple(Proof(**_numbers(Proof, p)) for p in given[key])
            given["domain"] = {k: (float(low), float(high)) for k, (low, high) in given["domain"].items()}
            return cls(**given)
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise EcfitError(f"malformed certificate ({type(error).__name__}: {error})") from None


_CHART = " (alpha = rho t, mu = rho (1 - t): nothing is 0 / 0)"
_NESTED = {
    "values": Range, "single": Drift, "single_hard": Drift, "half": Drift, "half_hard": Drift,
    "half_chart": Drift, "errors": SampledErrors, "corner_errors": SampledErrors,
    "half_errors": SampledErrors,
}  # fmt: skip
# What null stands for in a file: the infinity that JSON lacks.
_INFINITE = {k: float("-inf") for k in ("bound", "low", "room", "excess")}


def _numbers(kind: type, data: Mapping[str, Any]) -> dict[str, Any]:
    optional = {"identity"} if kind is Range else set()
    return {
        k: _INFINITE.get(k, float("inf")) if v is None and k not in optional else v for k, v in data.items()
    }


def _proof_lines(proofs: tuple[Proof, ...]) -> list[str]:
    """One line each, but one for all that need no attention beyond the first two."""
    lines = [p.describe() for p in proofs]
    if len(lines) <= 3 or not all(p.proven for p in proofs):
        return lines
    return [*lines[:2], f"{len(lines) - 2} more such claims: proved"]
