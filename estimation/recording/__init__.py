"""Run directories that survive a crash, and the recordings read back from them."""

from estimation.recording.data import Entry, Mark, Observed, Recorded, Recording, Rejections, Samples
from estimation.recording.files import CannotRecord
from estimation.recording.reader import read_recording
from estimation.recording.writer import RunWriter

__all__ = [
    "CannotRecord",
    "Entry",
    "Mark",
    "Observed",
    "Recorded",
    "Recording",
    "Rejections",
    "RunWriter",
    "Samples",
    "read_recording",
]
