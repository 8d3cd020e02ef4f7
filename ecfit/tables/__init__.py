"""Tables: a quantity on a grid, with an error estimate and a status per entry."""

from ecfit.tables.table import Table as Table
from ecfit.tables.tabulate import Request as Request
from ecfit.tables.tabulate import tabulate as tabulate
