"""What a processor can do, in a word."""

import pytest

from ecfit import _processor


@pytest.mark.parametrize(
    ("abilities", "word"),
    [
        ("flags\t\t: fpu sse4_2 avx avx2 fma avx512f avx512_fp16", "AVX-512"),
        ("flags : fpu avx2 avx sse4_2", "AVX2"),
        ("flags : fpu sse4_2 avx", "AVX"),
        ("flags : fpu sse4_2", "SSE4.2"),
        ("Features\t: fp asimd sve", "SVE"),
        ("Features : fp asimd", "NEON"),
        ("i386", "unknown"),
        ("", "unknown"),
    ],
)
def test_the_widest_set_is_named(monkeypatch: pytest.MonkeyPatch, abilities: str, word: str):
    monkeypatch.setattr(_processor, "abilities", lambda: abilities)
    assert _processor.instruction_set() == word
