"""Models: what there is, and whether a model is sound."""

from pathlib import Path

from ecfit.cli.arguments import Options, Plugins, options_of
from ecfit.errors import EcfitError


def list_(*, plugin: Plugins = ()) -> None:
    """List models with their options and parameters, quantities, forms, spacings and published fits."""
    from ecfit.approximation import published, published_names, shipped
    from ecfit.bsdf import models
    from ecfit.contract import QUANTITIES
    from ecfit.coordinates import SPACINGS, VIEWS
    from ecfit.forms import forms, registered_forms
    from ecfit.study.plugins import load_plugins
    from ecfit.tables import LAYOUTS

    load_plugins(plugin, Path())
    print("models")
    for name, cls in sorted(models().items()):
        print(f"  {name}: {_first_line(cls)}")
        for key, choices in cls.option_choices().items():
            print(f"    {key} = {' | '.join(choices)}")
        for key, (low, high) in cls.parameter_ranges().items():
            others = [v.name for v in VIEWS.values() if v.of == key]
            print(f"    {key} in [{low:g}, {high:g}]" + (f" (or {', '.join(others)})" if others else ""))
    print("quantities")
    for name, text in QUANTITIES.items():
        print(f"  {name}: {text}")
    print("forms")
    for name, cls in forms().items():
        print(f"  {name}: {_first_line(cls)}")
    print('modules (form = "module")')
    for name, made in sorted(registered_forms().items()):
        print(f"  {name}: {_first_line(made)}")
    print("spacings")
    for name, text in SPACINGS.items():
        print(f"  {name}: {text}")
    print("layouts of tables")
    for layout in LAYOUTS.values():
        print("\n".join(f"  {line}" for line in layout.describe()))
    print("shipped fits")
    for name in shipped():
        found = shipped(name)
        ends = ", ".join(
            f"{v} in [{a:g}, {b:g}]" for v, (a, b) in zip(found.variables, found.domain, strict=True)
        )
        print(f"  {name}: {found.contract.model}, {found.contract.quantity}, {ends}")
    print("published fits")
    for name in published_names():
        print(f"  {name}: {published(name).source}")


def _first_line(documented: object) -> str:
    return (documented.__doc__ or "").strip().partition("\n")[0]


def check_bsdf(model: str, *, option: Options = (), plugin: Plugins = (), samples: int = 500) -> None:
    """Check a model: finite, non-negative, reciprocal, energy <= 1, clean under jit, vmap and grad.

    Exits with 1 where a property fails.

    Parameters
    ----------
    model
        A registered model.
    samples
        Directions tried for each setting of the parameters.
    """
    import ecfit
    from ecfit.study.plugins import load_plugins

    load_plugins(plugin, Path())
    if samples < 1:
        raise EcfitError(f"samples must be 1 or more, got {samples}")
    found = ecfit.check_bsdf(ecfit.model(model, **options_of(option)), samples=samples)
    print(found)
    if not found:
        raise SystemExit(1)
