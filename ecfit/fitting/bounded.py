"""Levenberg-Marquardt whose bound on the number of steps is a number of the run, not of the program."""

from typing import Any

import lineax as lx
import optimistix as optx

from ecfit._jax import jax, jnp

Array = jax.Array


class BoundedLevenbergMarquardt(optx.LevenbergMarquardt):
    """Stops after `most` steps, as `max_steps` would, which Optimistix compiles into the program.

    Searches and last descents differ in the bound: with this they are one program, whose compilation takes
    longer than most descents.
    """

    most: Array

    def __init__(self, rtol: Any, atol: float, most: Any) -> None:
        super().__init__(rtol, atol, linear_solver=lx.QR())
        self.most = jnp.asarray(most)

    def terminate(self, fn: Any, y: Any, args: Any, options: Any, state: Any, tags: Any) -> Any:
        """Whether it is over, and how: Optimistix's answer, unless the steps are used up without one."""
        done, result = super().terminate(fn, y, args, options, state, tags)
        late = jnp.invert(done) & (state.num_steps >= self.most)
        return done, optx.RESULTS.where(late, optx.RESULTS.nonlinear_max_steps_reached, result)
