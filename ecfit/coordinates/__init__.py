"""Coordinates: named maps, axes with true coordinates, and grids. Nothing here imports JAX."""

from ecfit.coordinates.axis import SPACINGS as SPACINGS
from ecfit.coordinates.axis import Axis as Axis
from ecfit.coordinates.grid import Grid as Grid
from ecfit.coordinates.maps import MAPS as MAPS
from ecfit.coordinates.maps import Map as Map
from ecfit.coordinates.views import VIEWS as VIEWS
from ecfit.coordinates.views import View as View
from ecfit.coordinates.views import resolve as resolve
from ecfit.coordinates.views import view_of as view_of
from ecfit.coordinates.views import viewed as viewed
