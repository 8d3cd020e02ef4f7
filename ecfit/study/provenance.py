"""`provenance.json`: what the numbers of a study were made of.

Nothing here depends on how often, when, or with how many workers or threads a study was run, as its numbers
do not; where it ran is here, as another processor may move their last digits.
"""

import hashlib
import os
import platform
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ecfit._processor import instruction_set
from ecfit.files import read_text
from ecfit.tables import Table
from ecfit.tables.tabulate import versions


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
