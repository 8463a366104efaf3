"""Where the firmware's C sources lie: beside the package in a checkout, inside it when installed."""

from __future__ import annotations

from pathlib import Path

from hero_robot.firmware.errors import FirmwareError


def firmware_folder() -> Path:
    """The folder that holds ``core`` and ``hal``.

    Raises:
        FirmwareError: When the sources are not there.
    """
    package = Path(__file__).resolve().parent
    for folder in (package / "c_sources", package.parents[1] / "firmware"):
        if (folder / "core" / "hero_robot.c").is_file():
            return folder.resolve()
    raise FirmwareError(f"no firmware sources beside {package}; install the package whole, or work in a checkout")


def core_folder() -> Path:
    """The folder of the portable core."""
    return firmware_folder() / "core"
