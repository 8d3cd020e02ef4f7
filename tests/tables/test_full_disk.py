"""A disk that is full: one message, and neither a truncated table nor a part of it is left."""

import resource
import subprocess
import sys

import pytest

# A limit of the system on the size of files stands for the full disk: it ends writes with an error as well.
_CODE = """
import resource, signal, sys
import numpy as np
from ecfit import EcfitError, Table, write_table

size = int(sys.argv[1])
values = np.random.default_rng(1).random((size, size))
table = Table.from_array(values, {"r": size, "mu": size}, {"model": "unknown"})
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (512, resource.RLIM_INFINITY))
for name in sys.argv[2:]:
    try:
        write_table(table, name, number="float32")
    except EcfitError as error:
        print(error)
"""


@pytest.mark.skipif(not hasattr(resource, "RLIMIT_FSIZE"), reason="the system has no limit of this kind")
@pytest.mark.parametrize("size", [16, 64])  # small files fail where they are closed
def test_a_file_that_cannot_be_written_whole_is_told_and_removed(tmp_path, size):
    names = [f"t{ending}" for ending in (".csv", ".npy", ".exr", ".h", ".bin")]
    done = subprocess.run(
        [sys.executable, "-c", _CODE, str(size), *names],
        cwd=tmp_path, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    told = done.stdout.splitlines()
    for name, message in zip(names, told, strict=True):
        assert message.startswith(f"cannot write '{name}': "), message
    assert list(tmp_path.iterdir()) == []
