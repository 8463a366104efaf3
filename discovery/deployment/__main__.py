"""``python -m discovery.deployment``: the old name of ``python -m hero_robot.fleet``."""

import sys

from hero_robot.fleet.command import main

sys.exit(main())
