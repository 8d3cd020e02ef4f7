"""Approximations: coefficients with everything that gives them meaning; ours and the published ones."""

from ecfit.approximation.approximation import Approximation as Approximation
from ecfit.approximation.published import find as find
from ecfit.approximation.published import published as published
from ecfit.approximation.published import published_names as published_names
