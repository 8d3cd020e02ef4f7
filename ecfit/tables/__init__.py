"""Tables: a quantity on a grid, with an error estimate and a status per entry; ours and other people's."""

from ecfit.tables.consumers import LAYOUTS as LAYOUTS
from ecfit.tables.consumers import Layout as Layout
from ecfit.tables.foreign import Given as Given
from ecfit.tables.foreign import claim as claim
from ecfit.tables.foreign import read_table as read_table
from ecfit.tables.read_layout import read_layout as read_layout
from ecfit.tables.table import Table as Table
from ecfit.tables.tabulate import Request as Request
from ecfit.tables.tabulate import tabulate as tabulate
from ecfit.tables.write import write_table as write_table
