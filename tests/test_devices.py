"""Tables on several devices: the same numbers, and all devices have work."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

import ecfit
from ecfit._devices import device_count, over_rows, row_mesh
from ecfit._jax import jax, jnp

# 50 rows are no multiple of four devices; the tolerance sends some of them to the next levels.
AXES = {"r": [0.1, 0.3, 0.5, 0.7, 0.9], "mu": np.linspace(0.05, 0.95, 10).tolist()}
TOLERANCE = 1e-7

# XLA reads the number of devices when it starts, so this has to be a process of its own.
CHILD = """
import json, sys
import numpy as np
import ecfit
from ecfit._jax import jax, jnp
from ecfit.tables import tabulate as _
module = sys.modules["ecfit.tables.tabulate"]
axes, tolerance, path = json.loads(sys.argv[1])
whole, shares = module._evaluate, []

def watched(*arguments):
    found = whole(*arguments)
    shares.append({s.device.id: s.data.shape[0] for s in found.value.addressable_shards})
    return found

module._evaluate = watched

def table():
    shares.clear()
    return ecfit.tabulate("conductor", axes, tolerance=tolerance), list(shares)

spread, spread_shares = table()
with jax.default_device(jax.devices()[2]):
    alone, alone_shares = table()
np.savez(path, *(a for t in (spread, alone) for a in (t.values, t.errors, t.status)))
print(json.dumps([spread_shares, alone_shares]))
"""


@pytest.fixture(scope="module")
def on_four(tmp_path_factory):
    """Arrays (values, errors, status) on all devices and on one, and the rows that each device had."""
    path = tmp_path_factory.mktemp("devices") / "tables.npz"
    flags = f"{os.environ.get('XLA_FLAGS', '')} --xla_force_host_platform_device_count=4"
    found = subprocess.run(
        [sys.executable, "-c", CHILD, json.dumps([AXES, TOLERANCE, str(path)])],
        env={**os.environ, "XLA_FLAGS": flags},
        capture_output=True,
        text=True,
        check=True,
    )
    with np.load(path) as file:
        arrays = [file[name] for name in file.files]
    return arrays[:3], arrays[3:], *json.loads(found.stdout)


def test_four_devices_give_the_table_of_one(on_four):
    spread, alone, *_ = on_four
    here = ecfit.tabulate("conductor", AXES, tolerance=TOLERANCE)
    for values, errors, status in (spread, alone):
        # Bit for bit: every device runs the program that one runs, on other rows.
        np.testing.assert_array_equal(values, here.values)
        np.testing.assert_array_equal(status, here.status)
        # Estimates are differences of nearly equal sums: their last bit is the compiler's.
        np.testing.assert_allclose(errors, here.errors, rtol=1e-9)


def test_every_device_has_its_share_of_every_block(on_four):
    shares = on_four[2]
    assert len(shares) >= 2  # blocks: one or more a level
    for share in shares:
        assert sorted(share) == ["0", "1", "2", "3"]
        assert len(set(share.values())) == 1


def test_a_default_device_is_the_only_one(on_four):
    assert all(list(share) == ["2"] for share in on_four[3])


@pytest.mark.skipif(jax.local_device_count() > 1, reason="JAX has several devices here")
def test_one_device_needs_no_mesh():
    assert row_mesh() is None
    assert device_count(None) == 1

    def function(whole, rows):
        return rows + whole

    assert over_rows(function, None) is function


def test_a_mesh_of_one_device_changes_nothing():
    mesh = jax.sharding.Mesh(np.array(jax.local_devices()[:1]), ("rows",))
    assert device_count(mesh) == 1
    whole, rows = jnp.arange(3.0), jnp.arange(4.0)
    scale = jnp.asarray(2.0)

    def function(whole, rows):
        return scale * rows[:, None] + whole, rows

    pair = over_rows(function, mesh)(whole, rows)
    np.testing.assert_array_equal(pair[0], 2.0 * np.arange(4.0)[:, None] + np.arange(3.0))
    np.testing.assert_array_equal(pair[1], rows)
