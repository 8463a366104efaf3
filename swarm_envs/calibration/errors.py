"""The one error of this package."""


class LogError(ValueError):
    """A measured log cannot be used; one line that names the file, the row and the reason."""
