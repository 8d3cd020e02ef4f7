"""Certificates: what is proved of an approximation over its whole domain, and what is only measured."""

from ecfit.certify.certificate import Certificate as Certificate
from ecfit.certify.proofs import Proof as Proof
from ecfit.certify.run import certify as certify
from ecfit.certify.run import prove as prove
from ecfit.certify.truth import Sampling as Sampling
