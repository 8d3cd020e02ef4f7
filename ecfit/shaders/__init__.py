"""Exported code compiled and run by the tools of its target, and compared with NumPy.

The tools are optional: `missing` of each says what to install. The drivers of
devices import nothing of ecfit, so that this package may import JAX.
"""

from ecfit.shaders.cases import case as case
from ecfit.shaders.check import Agreement as Agreement
from ecfit.shaders.check import Outcome as Outcome
from ecfit.shaders.check import Report as Report
from ecfit.shaders.check import check as check
from ecfit.shaders.check import check_all as check_all
from ecfit.shaders.devices import NoDevice as NoDevice
from ecfit.shaders.program import Function as Function
from ecfit.shaders.tools import TOOLS as TOOLS
from ecfit.shaders.tools import Tool as Tool
from ecfit.shaders.tools import tool as tool
