"""Energy compensation: what albedos are for. Factors and lobes, compensated models, the numerical furnace."""

from ecfit.compensation.compensated import Compensated as Compensated
from ecfit.compensation.compensated import KullaConty as KullaConty
from ecfit.compensation.compensated import Turquin as Turquin
from ecfit.compensation.compensated import compensate as compensate
from ecfit.compensation.formulas import kulla_conty_fresnel as kulla_conty_fresnel
from ecfit.compensation.formulas import kulla_conty_lobe as kulla_conty_lobe
from ecfit.compensation.formulas import turquin_factor as turquin_factor
from ecfit.compensation.furnace import Furnace as Furnace
from ecfit.compensation.furnace import furnace as furnace
from ecfit.compensation.furnace import furnace_of as furnace_of
from ecfit.compensation.glossy import Glossy as Glossy
