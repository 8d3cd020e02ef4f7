"""Fitting: a form's coefficients from a table, by linearised starts and Levenberg-Marquardt."""

from ecfit.fitting.fit import Fitter as Fitter
from ecfit.fitting.fit import fit as fit
from ecfit.fitting.norms import NORMS as NORMS
from ecfit.fitting.result import STATUSES as STATUSES
from ecfit.fitting.result import Fit as Fit
