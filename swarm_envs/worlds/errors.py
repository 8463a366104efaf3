"""The one error that a bad world raises."""


class WorldError(ValueError):
    """A world cannot be used as written.

    The message is one line: where (file and key), what was given, what was expected, what to do.
    """
