"""The page of the command line, written from the commands themselves at every build."""

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from ecfit.cli.app import app


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add api/commands.md."""
    files.append(File.generated(config, "api/commands.md", content=app.generate_docs(heading_level=1)))
    return files
