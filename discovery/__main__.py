"""``python -m discovery``, also called ``swarm-discover``."""

from __future__ import annotations

import sys


def main() -> int:
    """Run the command; without the libraries of the discovery extra, say in one line how to install them."""
    try:
        from discovery.command import main as discover
    except ModuleNotFoundError as missing:
        if str(missing.name).partition(".")[0] in ("discovery", "swarm_envs"):
            raise  # not an extra's library: the package itself is broken
        print(f"discovery: {missing.name} is not installed; pip install 'swarm-envs[discovery]'", file=sys.stderr)
        return 1
    return discover()


if __name__ == "__main__":
    sys.exit(main())
