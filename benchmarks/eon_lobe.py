"""The numbers of the lobe form `eon`: their fit, their statistics against the source's, and figures.

python benchmarks/eon_lobe.py                            # ratios on a grid (a minute)
python benchmarks/eon_lobe.py --figures docs/figures     # the figures of docs/systems/eon.md, too
python benchmarks/eon_lobe.py --fit                      # the fit from the printed numbers (many minutes)
python benchmarks/eon_lobe.py --fit --quick              # the same, to its end, on six points
"""

from pathlib import Path

import common
import numpy as np

import ecfit
from ecfit.bsdf import BSDF
from ecfit.report.sampling import weights_over_angle, weights_over_roughness
from ecfit.report.style import rendered
from ecfit.sampling import TECHNIQUES, LobeForm, integrated, lobe_form, technique
from ecfit.sampling.refit import refit_lobe

FIT_MU = [0.01, 0.2, 0.4, 0.5, 0.6, 0.75, 0.9, 0.96, 1.0]
FIT_R = [0.2, 0.4, 0.65, 0.85, 1.0]
MU = [0.0, 0.01, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.7, 0.8, 0.9, 0.97, 1.0]
R = [0.01, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 1.0]
# Every how many points --quick takes, and its steps.
EVERY, STEPS = 4, 4
# Angles and roughnesses of the figures.
ANGLES, ROUGHNESS = 40, (0.25, 0.5, 0.75, 1.0)


def fitted(model: BSDF, printed: LobeForm, quick: bool) -> LobeForm:
    """The fit from the printed numbers, printed in six digits."""
    every, steps = (EVERY, STEPS) if quick else (1, 30)
    mu, r = np.array(FIT_MU[::every]), np.array(FIT_R[::every])[:, None]
    form = refit_lobe(model, printed, mu, r, max_steps=steps)
    for key in ("a", "b", "c", "d", "share"):
        print(key, [float(f"{v:.6g}") for v in getattr(form, key)])
    return form


def compare(model: BSDF, form: LobeForm, printed: LobeForm, quick: bool) -> None:
    """Ratios of variance and largest weight on the grid."""
    every = EVERY if quick else 1
    mu, r = np.array(MU[::every]), np.array(R[::every])[:, None]
    ours, theirs = (integrated(model, technique("cltc+uniform", f), mu, r) for f in (form, printed))
    for name, a, b in (
        ("variance", ours.variance, theirs.variance),
        ("largest weight", ours.largest, theirs.largest),
    ):
        ratio = np.asarray(a / b)
        worst = np.unravel_index(int(ratio.argmax()), ratio.shape)
        print(
            f"{name}: ratio mean {ratio.mean():.3f}, geometric {np.exp(np.log(ratio).mean()):.3f}, least "
            f"{ratio.min():.3f}, largest {ratio.max():.3f} at r = {r[worst[0], 0]}, mu = {mu[worst[1]]}; "
            f"greatest {float(a.max()):.4f} (printed {float(b.max()):.4f})"
        )
    np.set_printoptions(precision=2, suppress=True, linewidth=150)
    print(np.asarray(ours.variance / theirs.variance))


def draw(model: BSDF, folder: Path) -> None:
    """The source's figures 10 (r = 1, all techniques) and 12 (cosine against the mixture)."""
    pair = {name: technique(name) for name in ("cosine", "cltc+uniform")}
    figures = {
        "eon-weights": weights_over_angle(model, {n: technique(n) for n in TECHNIQUES}, 1.0, ANGLES),
        "eon-weights-roughness": weights_over_roughness(model, pair, ROUGHNESS, ANGLES),
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, figure in figures.items():
        (folder / f"{name}.svg").write_bytes(rendered(figure, "svg"))


def main() -> None:
    """Print what was fitted, how good it is, and draw."""
    parser = common.arguments(__doc__)
    parser.add_argument("--fit", action="store_true", help="fit from the printed numbers")
    parser.add_argument("--figures", type=Path, help="folder of the figures")
    given = parser.parse_args()
    model, printed = ecfit.model("eon"), lobe_form("portsmouth-2024")
    form = fitted(model, printed, given.quick) if given.fit else lobe_form("eon")
    compare(model, form, printed, given.quick)
    if given.figures is not None:
        draw(model, given.figures)


if __name__ == "__main__":
    main()
