"""Forms: parametrised families of functions, their terms, and bounds of polynomials over a box."""

from ecfit.forms.bernstein import Minimum as Minimum
from ecfit.forms.bernstein import minimum as minimum
from ecfit.forms.bernstein import smallest_denominator as smallest_denominator
from ecfit.forms.families import MAX_DEGREE as MAX_DEGREE
from ecfit.forms.families import Form as Form
from ecfit.forms.families import Polynomial as Polynomial
from ecfit.forms.families import Rational as Rational
from ecfit.forms.families import form as form
from ecfit.forms.families import forms as forms
from ecfit.forms.terms import Terms as Terms
from ecfit.forms.terms import total_degree as total_degree
