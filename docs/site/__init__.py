"""The site: what Sphinx reads, and the modules that write and build it."""
