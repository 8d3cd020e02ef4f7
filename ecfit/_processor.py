"""What this processor can do, as its system tells. No JAX here."""

import platform
from pathlib import Path

# From wide to narrow, as /proc/cpuinfo spells them; only those on which XLA and OpenBLAS choose other code.
_SETS = {
    "avx512f": "AVX-512",
    "avx2": "AVX2",
    "avx": "AVX",
    "sse4_2": "SSE4.2",
    "sve": "SVE",
    "asimd": "NEON",
}


def abilities() -> str:
    """The flags of the first processor on Linux; elsewhere what Python knows of it, which may be nothing."""
    try:
        lines = Path("/proc/cpuinfo").read_text().split("\n\n")[0].splitlines()
        return next((line for line in lines if line.startswith(("flags", "Features"))), "")
    except OSError:
        return platform.processor()


def instruction_set() -> str:
    """The widest set of instructions that XLA may use, such as "AVX2"; "unknown" where nobody says."""
    words = set(abilities().split())
    return next((name for flag, name in _SETS.items() if flag in words), "unknown")
