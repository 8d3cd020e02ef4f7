"""The typed form of a study's TOML file, with messages that name file, line and key. No JAX here."""

from ecfit.config.study import CHOICES as CHOICES
from ecfit.config.study import AxisConfig as AxisConfig
from ecfit.config.study import CompareConfig as CompareConfig
from ecfit.config.study import FitsConfig as FitsConfig
from ecfit.config.study import LookupConfig as LookupConfig
from ecfit.config.study import ReportConfig as ReportConfig
from ecfit.config.study import StudyConfig as StudyConfig
from ecfit.config.study import TableConfig as TableConfig
from ecfit.config.study import read_config as read_config
from ecfit.config.toml import key_lines as key_lines
from ecfit.config.toml import to_toml as to_toml
