"""What goes wrong around the firmware, in one line."""


class FirmwareError(RuntimeError):
    """The firmware could not be built or driven; the message says what was given, what was expected, and what to do."""
