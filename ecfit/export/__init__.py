"""Export: approximations as source text for renderers, from the one expression that is also certified."""

from ecfit.export.code import Options as Options
from ecfit.export.code import code as code
from ecfit.export.evidence import evidence_of as evidence_of
from ecfit.export.evidence import source as source
from ecfit.export.languages import LANGUAGES as LANGUAGES
from ecfit.export.materialx import materialx as materialx
from ecfit.export.write import write as write
