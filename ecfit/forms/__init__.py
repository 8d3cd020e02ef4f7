"""Forms: parametrised families of functions, their terms, and bounds of polynomials over a box."""

from ecfit.forms.bernstein import Minimum as Minimum
from ecfit.forms.bernstein import minimum as minimum
from ecfit.forms.bernstein import smallest_denominator as smallest_denominator
from ecfit.forms.composition import Composition as Composition
from ecfit.forms.families import MAX_DEGREE as MAX_DEGREE
from ecfit.forms.families import Form as Form
from ecfit.forms.families import Polynomial as Polynomial
from ecfit.forms.families import Rational as Rational
from ecfit.forms.families import TermsForm as TermsForm
from ecfit.forms.heads import HEADS as HEADS
from ecfit.forms.heads import Head as Head
from ecfit.forms.heads import head as head
from ecfit.forms.modules import ModuleForm as ModuleForm
from ecfit.forms.modules import register_form as register_form
from ecfit.forms.modules import registered_forms as registered_forms
from ecfit.forms.registry import form as form
from ecfit.forms.registry import forms as forms
from ecfit.forms.specified import Selected as Selected
from ecfit.forms.specified import Structured as Structured
from ecfit.forms.structured import Structure as Structure
from ecfit.forms.terms import Terms as Terms
from ecfit.forms.terms import total_degree as total_degree
