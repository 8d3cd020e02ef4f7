"""Approximations: coefficients with everything that gives them meaning; ours and the published ones."""

from ecfit.approximation.approximation import Approximation as Approximation
from ecfit.approximation.formula import Formula as Formula
from ecfit.approximation.formula import Quotient as Quotient
from ecfit.approximation.lookup import Lookup as Lookup
from ecfit.approximation.module import ModuleFormula as ModuleFormula
from ecfit.approximation.published import find as find
from ecfit.approximation.published import published as published
from ecfit.approximation.published import published_names as published_names
from ecfit.approximation.shipped import shipped as shipped
from ecfit.approximation.structured import StructuredFormula as StructuredFormula
from ecfit.approximation.tables import lookup_table as lookup_table
from ecfit.approximation.written import Written as Written
