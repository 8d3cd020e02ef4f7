"""The white furnace, and materials to look at, as pictures: spheres rendered by Mitsuba 3.

`ecfit.rendering.run.run_furnace` renders a config, `ecfit.rendering.numerical.run_numerical` integrates it.
Nothing is imported here: the process that renders has no use for JAX.
"""
