"""The one exception that a user's input can raise."""


class InputError(ValueError):
    """
    Bad input: the message is one line naming file, field, value and what was expected.

    Command lines print it without a traceback and end with exit code 2.
    """
