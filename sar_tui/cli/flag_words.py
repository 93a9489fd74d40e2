"""What the flags of a reach mean, in words."""

from collections.abc import Iterable, Iterator

_WORDS = {
    "no_rest": "the hand was not still before it, so the sensor's bias is a guess",
    "gap": "samples are missing in it",
    "cut": "the recording begins or ends in it",
    "timed_out": "it lasted too long, and was ended",
    "endless": "it never came to an end",
    "reversed": "out is not the way that this hand reaches out",
    "low_rate": "there are few samples a second, so its boundaries are less sure",
    "saturated": "it was faster than the sensor can measure, so only its times are known",
    "moving": "the hand was still moving when it was looked at",
    "error": "the sensor told of an error",
    "samples": "too few samples to find anything in",
    "rate": "too few samples a second to find anything in",
    "several": "there was more than one reach, and this is the largest",
}


def words(flags: Iterable[str]) -> Iterator[str]:
    """A line for each flag that occurs, once."""
    for flag in dict.fromkeys(flags):
        yield f"{flag}: {_WORDS[flag]}" if flag in _WORDS else flag
