"""Importance sampling: linearly transformed cosines, mixtures, and the statistics of their weights."""

from ecfit.sampling.coefficients import LobeForm as LobeForm
from ecfit.sampling.coefficients import lobe_form as lobe_form
from ecfit.sampling.coefficients import lobe_forms as lobe_forms
from ecfit.sampling.cosine import TransformedCosine as TransformedCosine
from ecfit.sampling.techniques import TECHNIQUES as TECHNIQUES
from ecfit.sampling.techniques import Technique as Technique
from ecfit.sampling.techniques import technique as technique
from ecfit.sampling.weights import Weights as Weights
from ecfit.sampling.weights import drawn as drawn
from ecfit.sampling.weights import integrated as integrated
