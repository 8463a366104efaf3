"""Builds the site: pages, clips, playground, then Sphinx without a warning. ``make docs`` runs it."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from docs.site import clips, generate  # noqa: E402  the repository is no installed package

BUILD = ROOT / "docs" / "_build"
STATIC = BUILD / "static"
PLAYGROUND = ROOT / "docs" / "playground"


def build_playground() -> Path:
    """Bundle the playground with the packages that its lock file pins; return the bundle."""
    npm = shutil.which("npm")
    if npm is None:
        raise SystemExit("npm is absent: the playground is built with it; on Debian and Ubuntu: apt-get install npm")
    lock, installed = PLAYGROUND / "package-lock.json", PLAYGROUND / "node_modules" / ".package-lock.json"
    if not installed.exists() or installed.stat().st_mtime < lock.stat().st_mtime:
        subprocess.run([npm, "ci", "--no-audit", "--no-fund", "--silent"], cwd=PLAYGROUND, check=True)
    STATIC.mkdir(parents=True, exist_ok=True)
    (BUILD / "playground").mkdir(exist_ok=True)
    (BUILD / "playground" / "data.js").write_text(generate.playground_data())
    subprocess.run([npm, "run", "build", "--silent"], cwd=PLAYGROUND, check=True)
    return STATIC / "playground.js"


def main() -> None:
    """Build everything into docs/_build/html."""
    generate.write()
    clips.film(STATIC / "clips")
    build_playground()
    html = BUILD / "html"
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-E", "-a", "-q", "-b", "html", str(ROOT / "docs"), str(html)]
    subprocess.run(command, cwd=ROOT, check=True)
    print(html / "index.html")


if __name__ == "__main__":
    main()
