"""Audits: is a table or a formula what its contract says, and if not, which convention went wrong?"""

from ecfit.auditing.audit import audit as audit
from ecfit.auditing.hypotheses import Hypothesis as Hypothesis
from ecfit.auditing.hypotheses import hypotheses as hypotheses
from ecfit.auditing.verdict import Audit as Audit
