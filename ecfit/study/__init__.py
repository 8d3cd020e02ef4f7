"""Studies: one TOML file crosses tables, forms and degrees; running it writes results and a report."""

from ecfit.study.plan import Plan as Plan
from ecfit.study.plan import make_plan as make_plan
from ecfit.study.run import Study as Study
from ecfit.study.run import load as load
from ecfit.study.run import run as run
