"""The whole study: every run of a plan, every evaluation of them, and the page; what is finished is never done again."""
