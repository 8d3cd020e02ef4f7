"""Exported code written to a file, or to the files of a library."""

from pathlib import Path

from ecfit.approximation import Approximation
from ecfit.errors import EcfitError
from ecfit.export.code import Options, parts, text
from ecfit.export.languages import language
from ecfit.export.materialx import materialx
from ecfit.files import make_folder, write_text


def write(approximation: Approximation, target: str, options: Options, output: Path | None) -> str:
    """Write a language's file or, for "materialx", a folder of files; what is to be printed is returned.

    Without `output` that is the code itself. Raises `EcfitError` as `ecfit.export.code`.
    """
    if target == "materialx":
        if output is None:
            raise EcfitError("a MaterialX library has several files: say --output FOLDER")
        files = {make_folder(output) / name: body for name, body in materialx(approximation, options).items()}
    else:
        found = language(target, also=("materialx",))
        body = text(found, *parts(approximation, found, options))
        if output is None:
            return body.rstrip("\n")
        files = {output: body}
    for path, body in files.items():
        write_text(path, body)
    return "\n".join(f"written: {path}" for path in files)
