"""The tools, as data: for each language the steps that compile it and the device that runs it."""

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ecfit.errors import EcfitError, unknown
from ecfit.export.compilers import CC, CXX, LIBRARY
from ecfit.shaders.compilers import GLSLANG, SLANGC, SPIRV_VAL, TINT, Step
from ecfit.shaders.devices import CYCLES, GL_COMPUTE, GL_FRAGMENT, PROCESSOR, WEBGPU, Device
from ecfit.shaders.program import Function, program


class Result(NamedTuple):
    """Values (functions, points) float32 and the device; None and "" where nothing is run."""

    values: np.ndarray | None
    device: str


@dataclass(frozen=True)
class Tool:
    """One way to compile, and mostly to run, exported code.

    Attributes:
        name: of the tool.
        language: of `ecfit.export`.
        entry: the program around the functions, a file in `entries`.
        steps: compilers, one after the other.
        device: where it runs, or None.
        shows: what a success proves, for people.
    """

    name: str
    language: str
    entry: str
    steps: tuple[Step, ...]
    device: Device | None
    shows: str

    def missing(self) -> str | None:
        """What has to be installed, or None; whether there is a device, a run tells."""
        wants = [step.compiler.missing() for step in self.steps]
        wants += [self.device.missing()] if self.device is not None else []
        return next((w for w in wants if w), None)

    def versions(self) -> str:
        """The compilers with their versions, in the order of their use."""
        return ", ".join(dict.fromkeys(step.compiler.describe() for step in self.steps))

    def compile(self, functions: Sequence[Function], points: int = 1) -> bytes:
        """What the steps make of the functions with the tool's entry.

        Raises `EcfitError` where a compiler refuses them.
        """
        made = program(self.entry, functions, points).encode()
        with tempfile.TemporaryDirectory(prefix="ecfit-") as folder:
            for step in self.steps:
                made = step.run(made, Path(folder))
        return made

    def run(self, functions: Sequence[Function], given: np.ndarray) -> Result:
        """Compile, and run where there is a device; one program for all functions.

        Args:
            functions: with names of their own each.
            given: points (functions, points, 4) float32; functions of fewer arguments take the first.

        Raises `EcfitError` where a compiler or the device fails, `NoDevice` where there is none.
        """
        made = self.compile(functions, given.shape[1])
        return Result(None, "") if self.device is None else Result(*self.device.run(made, given))


_STRICT = (*LIBRARY, "{source}", "-o", "{target}")
_C = Step(CC, ("-std=c11", *_STRICT, "-lm"), "program.c", "program.so")
_CPP = Step(CXX, ("-std=c++11", *_STRICT), "program.cpp", "program.so")
# Metal is C++14 with a standard library of its own; attributes ([[buffer(0)]]) mean nothing here.
_METAL = Step(
    CXX,
    ("-x", "c++", "-std=c++14", "-Wno-attributes", "-I{include}", *_STRICT),
    "program.metal",
    "program.so",
)
_VALIDATE = Step(SPIRV_VAL, ("--target-env", "vulkan1.2", "{source}"), "program.spv")
_GLSL = Step(GLSLANG, ("-V", "-S", "comp", "{source}", "-o", "{target}"), "program.comp", "program.spv")
_ESSL = Step(GLSLANG, ("-S", "frag", "{source}"), "program.frag")
_TINT = Step(TINT, ("--format", "wgsl", "{source}"), "program.wgsl")
_HLSL = Step(
    GLSLANG,
    ("-D", "-V", "-S", "comp", "-e", "main", "{source}", "-o", "{target}"),
    "program.hlsl",
    "program.spv",
)


def _slangc(language: str, target: str, ending: str, *more: str) -> Step:
    arguments = ("-lang", language, "{source}", "-target", target, *more, "-o", "{target}")
    return Step(SLANGC, arguments, f"program.{language}", f"made.{ending}")


# The kernel's name; and as little rewriting of the program as slangc offers.
_KERNEL = ("-entry", "main", "-stage", "compute", "-O0")

TOOLS: Mapping[str, Tool] = MappingProxyType({
    tool.name: tool
    for tool in (
        Tool("cc", "c", "library.c", (_C,), PROCESSOR, "C11 without a warning, run"),
        Tool("c++", "cpp", "library.cpp", (_CPP,), PROCESSOR, "C++11 without a warning, run"),
        Tool("c-as-c++", "c", "library.cpp", (_CPP,), PROCESSOR, "the C header in C++11, run"),
        Tool("opengl", "glsl", "compute.glsl", (), GL_COMPUTE, "GLSL 450 compute, run"),
        Tool("opengl-es", "glsl", "fragment.glsl", (_ESSL,), GL_FRAGMENT, "ESSL 300 fragment, run"),
        Tool("glslang", "glsl", "compute.glsl", (_GLSL, _VALIDATE), WEBGPU, "GLSL to SPIR-V, valid, run"),
        Tool("webgpu", "wgsl", "compute.wgsl", (), WEBGPU, "WGSL, read by naga, run"),
        Tool("tint", "wgsl", "compute.wgsl", (_TINT,), None, "WGSL, read by the compiler of Chrome"),
        Tool(
            "glslang-hlsl", "hlsl", "compute.hlsl", (_HLSL, _VALIDATE), WEBGPU,
            "HLSL to SPIR-V, valid, run",
        ),
        Tool(
            "slang-hlsl", "hlsl", "compute.hlsl", (_slangc("hlsl", "spirv", "spv", *_KERNEL),),
            WEBGPU, "HLSL, read by a second compiler, run",
        ),
        Tool(
            "slang", "slang", "library.slang", (_slangc("slang", "shader-sharedlib", "so"),), PROCESSOR,
            "Slang to C++ to machine code, run",
        ),
        Tool(
            "slang-spirv", "slang", "compute.slang", (_slangc("slang", "spirv", "spv", *_KERNEL),),
            WEBGPU, "Slang to SPIR-V, run",
        ),
        Tool(
            "slang-to-wgsl", "slang", "compute.slang", (_slangc("slang", "wgsl", "wgsl", *_KERNEL),), WEBGPU,
            "Slang to WGSL, run",
        ),
        Tool(
            "slang-to-glsl", "slang", "compute.slang",
            (_slangc("slang", "glsl", "comp", *_KERNEL), _GLSL, _VALIDATE), WEBGPU,
            "Slang to GLSL to SPIR-V, run",
        ),
        Tool(
            "slang-to-hlsl", "slang", "compute.slang",
            (_slangc("slang", "hlsl", "hlsl", *_KERNEL), _HLSL, _VALIDATE), None,
            "Slang to HLSL, compiled by glslang",
        ),
        Tool(
            "slang-to-metal", "slang", "compute.slang", (_slangc("slang", "metal", "metal", *_KERNEL),), None,
            "Slang to Metal, written only",
        ),
        Tool(
            "metal-as-c++", "msl", "library.metal", (_METAL,), PROCESSOR,
            "Metal as C++14 with a header in place of metal_stdlib, run; no Metal compiler",
        ),
        Tool("cycles", "osl", "probe.osl", (), CYCLES, "OSL in Blender's renderer, run"),
    )
})  # fmt: skip


def tool(name: str) -> Tool:
    """A tool by name. Raises `EcfitError` for an unknown one (it lists the known)."""
    if name not in TOOLS:
        raise unknown("tool", name, TOOLS)
    return TOOLS[name]


def of_language(language: str) -> list[Tool]:
    """All tools for a language. Raises `EcfitError` where there is none."""
    found = [t for t in TOOLS.values() if t.language == language]
    if not found:
        known = ", ".join(sorted({t.language for t in TOOLS.values()}))
        raise EcfitError(f"no tool here compiles '{language}': expected one of {known}")
    return found
