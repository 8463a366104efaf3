"""``report.html``: wrong here, because of this, now predicted so."""
