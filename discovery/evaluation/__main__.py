"""``python -m discovery.evaluation``."""

from discovery.evaluation.command import main

raise SystemExit(main())
