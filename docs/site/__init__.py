"""What makes the site: the modules that write its generated pages and pictures, their data, and the build."""
