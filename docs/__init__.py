"""The documentation: the pages that Sphinx reads, the studies, and what builds the site of them."""
