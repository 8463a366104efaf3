"""``python -m discovery``."""

from discovery.command import main

raise SystemExit(main())
