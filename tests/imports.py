"""Which modules of the repository import which, read from the sources."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = ("swarm_envs", "hero_robot", "discovery", "hardware", "docs")


def module_name(path: Path, root: Path = ROOT) -> str:
    """The dotted name of a file's module; a package's is that of its folder."""
    return ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__")


def imported(source: str, modules: Iterable[str]) -> set[str]:
    """The modules that a source names in its imports, anywhere in it; a name out of a module counts for that module."""
    known, found = set(modules), set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "relative import; name the module in full"
            base = node.module or ""
            found |= {name if (name := f"{base}.{alias.name}") in known else base for alias in node.names}
    return found


@cache
def imports() -> dict[str, set[str]]:
    """By module of the repository's packages, every module that it imports, those of others included."""
    paths = {module_name(path): path for package in PACKAGES for path in (ROOT / package).rglob("*.py") if "node_modules" not in path.parts}
    return {name: imported(path.read_text(encoding="utf-8"), paths) for name, path in paths.items()}
