"""Studies: one TOML file crosses tables, forms and degrees; running it writes results and a report."""

from ecfit.study.plan import Plan as Plan
from ecfit.study.plan import make_plan as make_plan
from ecfit.study.runner import Study as Study
from ecfit.study.runner import load as load
from ecfit.study.runner import run as run
