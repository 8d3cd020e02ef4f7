"""Where compiled programs run: a driver in a process of its own, as drivers of devices may crash."""

import importlib.util
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ecfit.errors import EcfitError

_DRIVERS = Path(__file__).with_name("drivers")
# Seconds; the first run of a device takes about 5.
_PATIENCE = 300.0
# Enough to run without a graphics card on Debian.
_DEVICES = "install libegl1, libgl1-mesa-dri, libvulkan1 and mesa-vulkan-drivers (make system)"


class NoDevice(EcfitError):
    """There is nothing to run on: no fault of the program."""


@dataclass(frozen=True)
class Device:
    """A driver (a script in `drivers`) that calls functions over points.

    Attributes:
        driver: its name.
        package: the Python package that it needs, or "".
        argument: handed on to the driver.
        variable: name of the environment variable that names the Python which has the package, for what is
            too big to share an environment; "" for the running one.
    """

    driver: str
    package: str = ""
    argument: str = ""
    variable: str = ""

    @property
    def python(self) -> str:
        """The Python that runs the driver."""
        return os.environ.get(self.variable) or sys.executable

    def missing(self) -> str | None:
        """What to install, or None where the package is there; whether there is a device, a run tells."""
        if self.variable:
            there = os.environ.get(self.variable)
            return None if there else f"no {self.package}: set {self.variable} to a Python that has it"
        if self.package and importlib.util.find_spec(self.package) is None:
            return f"no {self.package}: pip install 'ecfit[shaders]'"
        return None

    def run(self, program: bytes, given: np.ndarray) -> tuple[np.ndarray, str]:
        """Values (functions, points) at `given` (functions, points, 4), float32, and the device's name.

        Raises `NoDevice` where the driver ends before it has found one, and `EcfitError` where it fails
        later, with the last line that it printed.
        """
        with tempfile.TemporaryDirectory(prefix="ecfit-") as name:
            folder = Path(name)
            (folder / "program").write_bytes(program)
            np.save(folder / "given.npy", given)
            # -P: its folder is no place to import from. Without a folder for sockets Mesa only complains.
            command = [self.python, "-P", str(_DRIVERS / f"{self.driver}.py"), name, self.argument]
            environment = {"XDG_RUNTIME_DIR": name, **os.environ}
            try:
                done = subprocess.run(
                    command, capture_output=True, text=True, env=environment, timeout=_PATIENCE
                )
            except OSError as error:
                raise EcfitError(
                    f"cannot start {self.python}: {error.strerror}; see {self.variable}"
                ) from None
            except subprocess.TimeoutExpired:
                raise EcfitError(f"the driver {self.driver} hung for {_PATIENCE:.0f} s") from None
            told = folder / "device.txt"
            if done.returncode:
                lines = (done.stderr or done.stdout).strip().splitlines() or ["it said nothing"]
                why = f"({done.returncode}): {lines[-1].strip()}"
                if told.exists():
                    raise EcfitError(f"the driver {self.driver} failed {why}")
                raise NoDevice(f"the driver {self.driver} finds no device {why}; {_DEVICES}")
            return np.load(folder / "found.npy"), told.read_text().strip()


GL_COMPUTE = Device("gl", "moderngl", "compute")
GL_FRAGMENT = Device("gl", "moderngl", "fragment")
WEBGPU = Device("webgpu", "wgpu")
PROCESSOR = Device("library")
CYCLES = Device("cycles", "bpy", variable="ECFIT_BPY_PYTHON")
