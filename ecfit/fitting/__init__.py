"""Fitting: a form's coefficients from a table, by linearised starts and Levenberg-Marquardt."""

from ecfit.fitting.fit import STATUSES as STATUSES
from ecfit.fitting.fit import Fit as Fit
from ecfit.fitting.fit import Fitter as Fitter
from ecfit.fitting.fit import fit as fit
