# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What MkDocs does beside what mkdocs.yml says: pages that lie outside of docs/ are part of the manual.

In the repository their links lead from file to file; in the manual, from page to page.
"""

import re
from pathlib import Path

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parent.parent
# Files by the pages that they become.
OUTSIDE = {
    "benchmarks.md": "bench/README.md",
    "quad_tables.md": "bench/quads.md",
    "changelog.md": "CHANGELOG.md",
    "contributing.md": "CONTRIBUTING.md",
}


def on_files(files, config):
    for page, source in OUTSIDE.items():
        text = re.sub(r"\]\((?:\.\./)?docs/", "](", (ROOT / source).read_text(encoding="utf-8"))
        files.append(File.generated(config, page, content=text))
    return files


def on_page_markdown(markdown, page, config, files):
    for target, source in OUTSIDE.items():
        markdown = re.sub(rf"\]\((\.\./)?{re.escape(source)}", f"]({target}", markdown)
    return markdown
