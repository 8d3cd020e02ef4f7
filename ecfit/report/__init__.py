"""Reports: figures, a self-contained HTML page and a Markdown page of a study."""

from ecfit.report.figures import degree_vs_error as degree_vs_error
from ecfit.report.figures import error_along_axes as error_along_axes
from ecfit.report.figures import error_maps as error_maps
from ecfit.report.figures import table_and_fit as table_and_fit
from ecfit.report.write import write_report as write_report
