"""Studies, a package each: plan, code, page and figures. ``make study-NAME`` or ``python -m docs.studies.NAME`` runs one."""
