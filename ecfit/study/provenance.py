"""`provenance.json`: what the numbers of a study were made of.

Nothing here depends on how often, when, or with how many workers or threads a study was run, as its numbers
do not; where it ran is here, as another processor may move their last digits. For a cluster that is where the
tables were integrated and the run was started: workers have the same versions, maybe other processors.
"""

import hashlib
import os
import platform
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from ecfit._processor import instruction_set
from ecfit._versions import versions
from ecfit.errors import EcfitError
from ecfit.files import read_json, read_text, write_json
from ecfit.tables import Table


def config_hash(folder: Path) -> str:
    """SHA-256 of the resolved config in a study's folder."""
    return hashlib.sha256(read_text(folder / "config.toml").encode()).hexdigest()


def machine() -> dict[str, str]:
    """What of this machine may move last digits: system, instruction set, and what XLA is told."""
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "instructions": instruction_set(),
        "xla_flags": os.environ.get("XLA_FLAGS", ""),
    }


def provenance(name: str, folder: Path, tables: Mapping[str, Table]) -> dict[str, Any]:
    """Of the study `name` in `folder`: versions, machine, hashes of its config and of its tables' numbers.

    Tables that an earlier run integrated say the versions of that run.
    """
    return {
        "study": name,
        "config": config_hash(folder),
        "versions": versions(),
        "machine": machine(),
        "tables": {
            table_name: {
                "key": table.provenance.get("key", ""),
                "values": table.digest,
                "versions": dict(table.provenance),
            }
            for table_name, table in tables.items()
        },
    }


def write_provenance(name: str, folder: Path, tables: Mapping[str, Table], computed: bool) -> None:
    """Write `provenance.json` of a run, arguments as for `provenance`.

    Where a run `computed` nothing, versions and machine stay those of the run before it.
    """
    path = folder / "provenance.json"
    made = provenance(name, folder, tables)
    if not computed:
        with suppress(EcfitError):  # missing or damaged: written anew
            before = read_json(path)
            if isinstance(before, dict):
                made |= {k: before[k] for k in ("versions", "machine") if isinstance(before.get(k), dict)}
    write_json(path, made)
