"""The documentation: guides as Markdown, and the site that is built of them."""
