"""``python -m discovery.deployment``."""

import sys

from discovery.deployment.command import main

sys.exit(main())
