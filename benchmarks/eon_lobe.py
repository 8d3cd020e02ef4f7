"""The numbers of the lobe form `eon`, and its statistics against those of the source's.

python benchmarks/eon_lobe.py          # ratios on a grid (a minute)
python benchmarks/eon_lobe.py --fit    # the fit from the printed numbers (many minutes)
"""

import sys

import numpy as np

import ecfit
from ecfit.sampling import integrated, lobe_form, technique
from ecfit.sampling.refit import refit_lobe

FIT_MU = [0.01, 0.2, 0.4, 0.5, 0.6, 0.75, 0.9, 0.96, 1.0]
FIT_R = [[0.2], [0.4], [0.65], [0.85], [1.0]]
MU = np.array(
    [0.0, 0.01, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.7, 0.8, 0.9, 0.97, 1.0]
)
R = np.array([0.01, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 1.0])[:, None]


def main() -> None:
    """Print what was fitted, or how good it is."""
    model, printed = ecfit.model("eon"), lobe_form("portsmouth-2024")
    if "--fit" in sys.argv:
        form = refit_lobe(model, printed, np.array(FIT_MU), np.array(FIT_R))
        for key in ("a", "b", "c", "d", "share"):
            print(key, [float(f"{v:.6g}") for v in getattr(form, key)])
    else:
        form = lobe_form("eon")
    ours, theirs = (integrated(model, technique("cltc+uniform", f), MU, R) for f in (form, printed))
    for name, a, b in (
        ("variance", ours.variance, theirs.variance),
        ("largest weight", ours.largest, theirs.largest),
    ):
        ratio = np.asarray(a / b)
        worst = np.unravel_index(int(ratio.argmax()), ratio.shape)
        print(
            f"{name}: ratio mean {ratio.mean():.3f}, geometric {np.exp(np.log(ratio).mean()):.3f}, least "
            f"{ratio.min():.3f}, largest {ratio.max():.3f} at r = {R[worst[0], 0]}, mu = {MU[worst[1]]}; "
            f"greatest {float(a.max()):.4f} (printed {float(b.max()):.4f})"
        )
    np.set_printoptions(precision=2, suppress=True, linewidth=150)
    print(np.asarray(ours.variance / theirs.variance))


if __name__ == "__main__":
    main()
