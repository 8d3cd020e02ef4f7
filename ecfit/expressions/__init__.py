"""Expressions: one tree for each formula, evaluated by NumPy, JAX, narrow floats or intervals."""

from ecfit.expressions.cost import Cost as Cost
from ecfit.expressions.cost import cost as cost
from ecfit.expressions.derivative import derivative as derivative
from ecfit.expressions.evaluate import evaluate as evaluate
from ecfit.expressions.evaluate import value as value
from ecfit.expressions.node import Node as Node
from ecfit.expressions.node import const as const
from ecfit.expressions.node import maximum as maximum
from ecfit.expressions.node import minimum as minimum
from ecfit.expressions.node import power as power
from ecfit.expressions.node import sqrt as sqrt
from ecfit.expressions.node import step as step
from ecfit.expressions.node import substitute as substitute
from ecfit.expressions.node import unary as unary
from ecfit.expressions.node import var as var
from ecfit.expressions.parse import parse as parse
