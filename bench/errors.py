"""Errors a user can do something about: one sentence saying what is wrong, where, and what would be right."""


class BenchError(Exception):
    """Base of every error that is shown to the user as one sentence, without a traceback."""


class RecordingError(BenchError):
    """A recording that does not meet the recording format, or that an analysis cannot use."""


class ConfigurationError(BenchError):
    """A bench, campaign, plant or simulation file with a wrong key or value."""


class LimitError(BenchError):
    """A plan or a set value that would break a limit of the bench."""


class DeviceError(BenchError):
    """A device that is missing, of the wrong identity, faulty or silent."""
