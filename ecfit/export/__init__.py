"""Export: approximations as source text for renderers, from the one expression that is also certified."""

from ecfit.export.code import code as code
from ecfit.export.evidence import evidence_from as evidence_from
from ecfit.export.evidence import evidence_of as evidence_of
from ecfit.export.languages import LANGUAGES as LANGUAGES
