"""Errors that a user may see. Each message is one plain paragraph: what, where, what to do."""


class BematistError(Exception):
    """Base of the errors raised on purpose; the command line prints the message and exits with `exit_code`."""

    exit_code = 1


class DataError(BematistError):
    """The data cannot be processed (exit code 1)."""


class UsageError(BematistError):
    """The call is wrong: an unknown method, option or name (exit code 2)."""

    exit_code = 2
