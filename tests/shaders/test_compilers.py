"""Compilers are found, say their version, and their refusals reach the reader."""

import shutil

import pytest

from ecfit.errors import EcfitError
from ecfit.export.compiled import compiled
from ecfit.shaders.compilers import CC, COMPILERS, GLSLANG, Compiler
from ecfit.shaders.program import Function
from ecfit.shaders.tools import TOOLS, of_language, tool

needs_cc = pytest.mark.skipif(CC.missing() is not None, reason=str(CC.missing()))
needs_glslang = pytest.mark.skipif(GLSLANG.missing() is not None, reason=str(GLSLANG.missing()))


def test_a_missing_compiler_says_what_to_install():
    absent = Compiler("no-such-compiler", "from the moon")
    assert absent.missing() == "no no-such-compiler: from the moon"
    assert absent.describe() == "no-such-compiler"


@pytest.mark.parametrize("name", list(COMPILERS))
def test_a_compiler_tells_its_version(name):
    compiler = COMPILERS[name]
    if compiler.missing() or not compiler.version:
        pytest.skip(compiler.missing() or f"{name} has no version")
    assert name in compiler.describe()
    assert any(c.isdigit() for c in compiler.describe())


@needs_cc
def test_the_environment_chooses_the_compiler(monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    assert "set CC" in str(CC.missing())


@needs_cc
def test_the_environment_may_give_the_compiler_arguments(monkeypatch, tmp_path):
    """As make reads it: CC = "ccache gcc" is a command with an argument. Here they end in an error of cc."""
    path = shutil.which("cc")
    monkeypatch.setenv("CC", "cc -O1 '-DNAME=a b'")
    assert CC.command() == [path, "-O1", "-DNAME=a b"]
    assert "cc" in CC.describe()
    monkeypatch.setenv("CC", "cc -Dx=@")
    with pytest.raises(EcfitError, match="refuses the exported code"):
        TOOLS["cc"].compile([Function("f", 1, "static inline float f(float x) { return x; }")])
    with pytest.raises(EcfitError, match="refuses the exported code"):
        compiled(["static inline float f(float x) { return x; }"], [("f", 1)])


def test_a_quote_that_is_not_closed_is_no_compiler(monkeypatch):
    monkeypatch.setenv("CC", "cc 'x")
    assert CC.missing()


@needs_cc
@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("static inline float f(float x) { return x }", "error"),
        ("static inline float f(float x) { return x * 0.1; }", "double"),
        ("static inline float f(float x) { float unused = x; return x; }", "unused"),
    ],
)
def test_errors_and_warnings_of_the_c_compiler_are_refusals(source, said):
    with pytest.raises(EcfitError, match=rf"refuses the exported code.*{said}"):
        TOOLS["cc"].compile([Function("f", 1, source)])


@needs_glslang
def test_a_type_error_in_glsl_is_refused():
    with pytest.raises(EcfitError, match="glslangValidator refuses the exported code"):
        TOOLS["glslang"].compile([Function("f", 1, "float f(float x) { return vec2(x); }")])


@needs_glslang
def test_a_local_constant_that_is_none_is_refused_in_es():
    """ESSL 3.00, 4.3.3: const is for constant expressions; desktop GLSL since 4.20 allows more."""
    source = "float f(float x) { const float y = x * x; return y; }"
    with pytest.raises(EcfitError, match="non-constant initializer"):
        TOOLS["opengl-es"].compile([Function("f", 1, source)])


def test_tools_are_found_by_name_and_language():
    assert tool("cc") is TOOLS["cc"]
    assert {t.name for t in of_language("wgsl")} == {"webgpu", "tint"}
    with pytest.raises(EcfitError, match="did you mean 'webgpu'"):
        tool("webgp")
    with pytest.raises(EcfitError, match="no tool here compiles 'cobol': expected one of c, cpp"):
        of_language("cobol")
