"""The old name of :mod:`hero_robot.firmware.constants`, kept for one version."""

import sys

from hero_robot.firmware.constants import *  # noqa: F403
from hero_robot.firmware.constants import main

if __name__ == "__main__":
    print("python -m hero_firmware.constants is now python -m hero_robot.firmware.constants; use that", file=sys.stderr)
    main()
