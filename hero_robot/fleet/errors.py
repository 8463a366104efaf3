"""What goes wrong with a fleet, in one line."""


class FleetError(RuntimeError):
    """A fleet file, a command or a server is wrong; the message says what was given, what was expected, and what to do."""
