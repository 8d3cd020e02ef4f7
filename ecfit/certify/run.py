"""`certify`: prove what can be proved of an approximation, measure the rest."""

import numpy as np

from ecfit.approximation import Approximation
from ecfit.certify.certificate import Certificate
from ecfit.certify.narrow import drift, half_safe, hard_points, single_bound
from ecfit.certify.proofs import Ceiling, Proof, defined, divisors, floors, value_range
from ecfit.certify.subject import Subject
from ecfit.certify.truth import Points, SampledErrors, Sampling, corner_points, measure
from ecfit.errors import EcfitError
from ecfit.expressions import const, sqrt, var
from ecfit.tables.scattered import Scattered, integrate, of_contract

# Points near the edges for narrow arithmetic, and towards the corner for the truth, as parts of the sample.
_HARD, _CORNER = 1.0, 0.02
# Of the points at which an identity behind a proof is checked.
_PROOF_SEED = 1


def certify(
    approximation: Approximation,
    *,
    samples: int = 20_000,
    seed: int = 1,
    sampling: Sampling | None = None,
    tolerance: float = 1e-8,
) -> Certificate:
    """A certificate: proofs over the whole closed domain, and measurements that are said to be such.

    Args:
        approximation: anything with an expression; tables have none.
        samples: random points at which the model is integrated.
        seed: of the random points.
        sampling: another rule for them, in place of `samples` and `seed`.
        tolerance: of the integrals.

    Returns a `Certificate`; it says itself whether it was granted, and if not, why.
    Raises `EcfitError` for tables and for a sample that has no point in the domain.
    """
    rule = sampling if sampling is not None else Sampling(samples, seed)
    subject = Subject.of(approximation)
    points = rule.points(approximation)
    hard = hard_points(approximation, max(1, int(_HARD * rule.count)), rule.seed)
    subject, proofs, sound = _divided(subject)
    errors, corner, in_half, why = _truth(approximation, points, rule, tolerance)
    least = {name: max(p.bound, 0.0) for (name, _, _), p in zip(subject.divisors, proofs, strict=True)}
    rounding = single_bound(subject, least) if sound else None
    chart = half_safe(subject)
    everywhere = {n: np.concatenate([points[n], hard[n]]) for n in approximation.variables}
    return Certificate(
        name=approximation.name,
        domain=dict(zip(approximation.variables, approximation.domain, strict=True)),
        charted=chart is not None,
        divisors=proofs,
        defined=defined(subject),
        values=value_range(subject, ceiling(approximation), rule.seed) if sound else None,
        at_corner=_at_corner(approximation, subject),
        single_bound=None if rounding is None else -rounding.bound,
        single_place={} if rounding is None else subject.place(rounding.place),
        single=drift(subject.plain, points, "float32"),
        single_hard=drift(subject.plain, hard, "float32"),
        half=drift(subject.plain, points, "float16"),
        half_hard=drift(subject.plain, hard, "float16"),
        half_chart=None if chart is None else drift(chart, everywhere, "float16", charted=True),
        sampling=rule.to_dict(),
        truth_tolerance=tolerance,
        errors=errors,
        corner_errors=corner,
        no_truth=why,
        half_errors=in_half,
    )


def prove(approximation: Approximation) -> tuple[str, ...]:
    """The proofs of `certify` without its measurements: why they fail, or nothing where all succeed.

    They are that no divisor vanishes on the closed domain, that roots are real there, and that values lie
    between 0 and what the quantity cannot exceed. Raises `EcfitError` for tables, which have no expression.
    """
    subject, proofs, sound = _divided(Subject.of(approximation))
    faults = [p.describe() for p in (*proofs, *defined(subject)) if not p.proven]
    if sound:
        faults += value_range(subject, ceiling(approximation), _PROOF_SEED).faults
    return tuple(faults)


def _divided(subject: Subject) -> tuple[Subject, tuple[Proof, ...], bool]:
    """The subject, knowing what divisors exceed where all are proved > 0; the proofs; whether all are."""
    proofs = divisors(subject)
    sound = all(p.proven for p in proofs)
    return (subject.knowing(floors(subject, proofs)) if sound else subject), proofs, sound


def ceiling(approximation: Approximation) -> Ceiling | None:
    """What the quantity of a contract cannot exceed, or None.

    Energy is at most 1, also by the claim of an unknown model. A radiance that leaves a dielectric is scaled
    by ior^2, so R + T <= ior^2 where the energies have R + T <= 1; one that enters it is scaled down.
    """
    contract = approximation.contract
    try:
        bsdf, quantity = of_contract(contract)
    except EcfitError:
        return Ceiling("1", const(1.0)) if contract.transport == "energy" else None
    if quantity.bounded(bsdf):
        return Ceiling("1", const(1.0))
    if contract.model != "dielectric":
        return None
    if contract.options.get("side", bsdf.options().get("side")) == "entering":
        return Ceiling("1", const(1.0))
    for name in ("ior", "F0"):
        if name in approximation.variables:
            s = sqrt(var("F0"))
            ior = var("ior") if name == "ior" else (1.0 + s) / (1.0 - s)
            return Ceiling("ior^2", ior * ior)
    fixed = float(np.asarray(bsdf.parameter_value("ior")))
    return Ceiling("ior^2", const(fixed) * const(fixed))


def _truth(
    approximation: Approximation, points: Points, rule: Sampling, tolerance: float
) -> tuple[SampledErrors | None, SampledErrors | None, SampledErrors | None, str]:
    """Errors on the sample, towards the corner, on the sample in half precision; or why there are none."""
    near = corner_points(approximation, max(50, int(_CORNER * rule.count)), rule.seed)
    # One call for both: most of the time of a small sample is compilation.
    together = {n: np.concatenate([p, near[n]]) if near else p for n, p in points.items()}
    try:
        truth = integrate(approximation.contract, together, tolerance)
    except EcfitError as error:
        return None, None, None, str(error)
    first = Scattered(*(a[: rule.count] for a in truth))
    second = Scattered(*(a[rule.count :] for a in truth))
    errors = measure(approximation, points, first)
    why = "" if errors is not None else "no integral of the sample converges"
    towards = measure(approximation, near, second) if near else None
    return errors, towards, measure(approximation, points, first, "float16"), why


def _at_corner(approximation: Approximation, subject: Subject) -> float | None:
    """The value at alpha = mu = 0 and the lowest other coordinates, where the form has that corner."""
    ranges = subject.domain.ranges
    corner = {"alpha", "mu"} <= set(ranges) and ranges["alpha"][0] == ranges["mu"][0] == 0.0
    if not (subject.charted and corner):
        return None
    place = [np.float64(ranges[n][0]) for n in approximation.variables]
    return float(np.asarray(approximation.formula.value(place)))
