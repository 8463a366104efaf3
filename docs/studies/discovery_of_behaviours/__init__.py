"""What the paper reports of discovery, done again: every run of a plan, every evaluation, and the page. Nothing finished is done again."""
