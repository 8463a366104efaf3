"""``python -m discovery.annotation``."""

from discovery.annotation.command import main

raise SystemExit(main())
