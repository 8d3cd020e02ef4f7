"""Families of forms that a config can name."""

import abc
import numbers

import equinox as eqx
import numpy as np

from ecfit.errors import EcfitError
from ecfit.forms.terms import Terms, total_degree

# Beyond this the monomials of a total degree in 64 bits carry no information that a table resolves.
MAX_DEGREE = 20


def _check_degree(name: str, degree: object, least: int) -> None:
    if not isinstance(degree, numbers.Integral) or isinstance(degree, bool):
        raise EcfitError(f"{name} must be an integer, got {degree!r}")
    if not least <= degree <= MAX_DEGREE:  # pyright: ignore[reportOperatorIssue]
        raise EcfitError(f"{name} must be in {least}..{MAX_DEGREE}, got {degree}")


class Form(eqx.Module):
    """A family of functions of n variables with a finite number of coefficients."""

    @property
    @abc.abstractmethod
    def name(self) -> str:
        """The word that configs and summaries use."""

    @property
    @abc.abstractmethod
    def degree(self) -> str:
        """The degree in words: "3", or "4/2" for numerator / denominator."""

    @abc.abstractmethod
    def count(self, variables: int) -> int:
        """Number of coefficients in that many variables."""

    @property
    def linear(self) -> bool:
        """Whether the coefficients enter linearly (no denominator)."""
        return False


class TermsForm(Form):
    """Quotients of polynomials with all terms of a degree."""

    @abc.abstractmethod
    def terms(self, variables: int) -> Terms:
        """The terms in that many variables."""

    def count(self, variables: int) -> int:
        return self.terms(variables).count

    @property
    def may_have_poles(self) -> bool:
        """Whether a fit may let the denominator change its sign."""
        return False

    def coarser(self) -> "TermsForm | None":
        """The next smaller form whose terms are among this one's: its optimum is a start for this one."""
        return None


class Polynomial(TermsForm):
    """All monomials of total degree <= `degree` (1..20). Raises `EcfitError` outside that range."""

    order: int

    def __init__(self, degree: int) -> None:
        _check_degree("degree", degree, 1)
        self.order = int(degree)

    @property
    def name(self) -> str:
        return "polynomial"

    @property
    def degree(self) -> str:
        return str(self.order)

    @property
    def linear(self) -> bool:
        return True

    def terms(self, variables: int) -> Terms:
        return Terms(total_degree(variables, self.order), np.zeros((0, variables), dtype=np.int64))


class Rational(TermsForm):
    """P / Q with all monomials of a total degree each, Q with constant 1.

    `Rational(degree=3)` has equal degrees; `Rational(numerator=4, denominator=2)` sets them apart
    (0..20 each, not both 0). With `guarded=False` the fit is the least-squares optimum even where Q changes
    its sign in the domain: a reproduction of what others published, not for use. Raises `EcfitError`
    otherwise.
    """

    numerator: int
    denominator: int
    guarded: bool

    def __init__(
        self,
        degree: int | None = None,
        *,
        numerator: int | None = None,
        denominator: int | None = None,
        guarded: bool = True,
    ) -> None:
        if not isinstance(guarded, bool):
            raise EcfitError(f"guarded must be true or false, got {guarded!r}")
        if degree is not None:
            if numerator is not None or denominator is not None:
                raise EcfitError("Rational takes either degree, or numerator and denominator")
            _check_degree("degree", degree, 1)
            numerator = denominator = degree
        if numerator is None or denominator is None:
            raise EcfitError("Rational needs a degree, or both numerator and denominator")
        _check_degree("numerator", numerator, 0)
        _check_degree("denominator", denominator, 0)
        if numerator == denominator == 0:
            raise EcfitError("Rational of degree 0/0 is a constant: use a degree of 1 or more")
        self.numerator, self.denominator = int(numerator), int(denominator)
        self.guarded = guarded

    @property
    def name(self) -> str:
        return "rational" if self.guarded else "rational-unguarded"

    @property
    def degree(self) -> str:
        if self.numerator == self.denominator:
            return str(self.numerator)
        return f"{self.numerator}/{self.denominator}"

    def terms(self, variables: int) -> Terms:
        return Terms(total_degree(variables, self.numerator), total_degree(variables, self.denominator)[1:])

    @property
    def linear(self) -> bool:
        return self.denominator == 0

    @property
    def may_have_poles(self) -> bool:
        return not self.guarded

    def coarser(self) -> TermsForm | None:
        numerator, denominator = max(self.numerator - 1, 0), max(self.denominator - 1, 0)
        if numerator == denominator == 0:
            return None
        return Rational(numerator=numerator, denominator=denominator, guarded=self.guarded)
