"""The white furnace, and materials to look at, as pictures: spheres rendered by Mitsuba 3."""

from ecfit.rendering.run import run_furnace as run_furnace
from ecfit.rendering.verdict import Verdict as Verdict
from ecfit.rendering.verdict import verdict as verdict
