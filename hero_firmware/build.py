"""The old name of :mod:`hero_robot.firmware.build`, kept for one version."""

import sys

from hero_robot.firmware.build import *  # noqa: F403
from hero_robot.firmware.build import main

if __name__ == "__main__":
    print("python -m hero_firmware.build is now python -m hero_robot.firmware.build; use that", file=sys.stderr)
    sys.exit(main())
