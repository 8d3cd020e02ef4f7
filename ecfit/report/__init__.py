"""Reports and plots: figures, a self-contained HTML page and a Markdown page of a study."""

from ecfit.report.figures import degree_vs_error as degree_vs_error
from ecfit.report.figures import error_along_axes as error_along_axes
from ecfit.report.figures import error_maps as error_maps
from ecfit.report.figures import table_and_fit as table_and_fit
from ecfit.report.plots import plot_error as plot_error
from ecfit.report.plots import plot_error_against_cost as plot_error_against_cost
from ecfit.report.plots import plot_error_along as plot_error_along
from ecfit.report.plots import plot_slice as plot_slice
from ecfit.report.plots import plot_table as plot_table
from ecfit.report.write import write_report as write_report
