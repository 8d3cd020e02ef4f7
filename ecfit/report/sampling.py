"""Figures of sampling weights: functions that return a Matplotlib figure and write nothing."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from ecfit.bsdf import BSDF
from ecfit.report.style import look
from ecfit.sampling.techniques import Technique
from ecfit.sampling.weights import integrated


def weights_over_angle(model: BSDF, techniques: Mapping[str, Technique], r: float, count: int = 40) -> Figure:
    """Variance, largest and mean weight against the angle of view (Portsmouth et al. 2024, figure 10).

    Of densities above 1e-4 only: without a cut the variance of a lobe alone is infinite.
    """
    theta = np.linspace(0.0, 89.5, count)
    with look():
        figure = Figure(figsize=(10.0, 3.2), layout="constrained")
        axes = figure.subplots(1, 3)
        for label, technique in techniques.items():
            found = integrated(model, technique, np.cos(np.radians(theta)), r, cut=1e-4)
            for axis, values in zip(axes, (found.variance, found.largest, found.mean), strict=True):
                axis.plot(theta, values, label=label, linewidth=1.2)
        titles = ("variance of the weight", "largest weight", "mean weight")
        for axis, title in zip(axes, titles, strict=True):
            axis.set(xlabel="angle of view in degrees", title=title)
        axes[0].set_yscale("log")
        axes[1].set_yscale("log")
        axes[0].legend(fontsize=7, frameon=False)
    return figure


def weights_over_roughness(
    model: BSDF, techniques: Mapping[str, Technique], roughness: Sequence[float], count: int = 24
) -> Figure:
    """Variance and largest weight against the angle, a line for each roughness (the source's figure 12)."""
    theta = np.linspace(0.0, 89.5, count)
    with look():
        figure = Figure(figsize=(8.0, 3.2), layout="constrained")
        axes = figure.subplots(1, 2)
        for style, (label, technique) in zip(("-", "--", ":"), techniques.items(), strict=False):
            for i, r in enumerate(roughness):
                found = integrated(model, technique, np.cos(np.radians(theta)), r)
                for axis, values in zip(axes, (found.variance, found.largest), strict=True):
                    axis.plot(theta, values, style, color=f"C{i}", linewidth=1.2, label=f"{label}, r = {r:g}")
        for axis, title in zip(axes, ("variance of the weight", "largest weight"), strict=True):
            axis.set(xlabel="angle of view in degrees", title=title, yscale="log")
        axes[0].legend(fontsize=6, frameon=False)
    return figure
