"""The page of the command line, written from the commands themselves at every build."""

import re

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from ecfit.cli.app import app


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add api/commands.md."""
    text = app.generate_docs(heading_level=1).replace("# ecfit\n", "# Command line\n", 1)
    # The site has a table of contents at the side.
    text = re.sub(r"## Table of Contents\n.*?(?=\*\*Commands\*\*)", "", text, flags=re.DOTALL)
    files.append(File.generated(config, "api/commands.md", content=text))
    return files
