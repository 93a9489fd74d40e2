"""Messages between the program and its child programs for sound: one JSON line each."""

from typing import Literal

import msgspec

from sar_tui.model.theme import Note


class SoundError(ValueError):
    """Something cannot be played. The message is one or two sentences for a person.

    ``is_of_text``: the text cannot be spoken; the engine is not at fault.
    """

    def __init__(self, message: str, *, is_of_text: bool = False) -> None:
        super().__init__(message)
        self.is_of_text = is_of_text


class _Line(msgspec.Struct, frozen=True, tag_field="is", tag=str.lower):
    """One message."""


class Setup(_Line, frozen=True):
    """The first message. Sounds go to ``folder`` as WAV files, or to the sound card if that is
    empty.

    ``backends``: the sound systems to try, by miniaudio's names; all real ones if empty. If
    ``in_real_time`` is false, nothing is played and each sound ends when it starts: the program's
    clock is virtual.
    """

    folder: str = ""
    backends: tuple[str, ...] = ()
    in_real_time: bool = True


class Voicing(msgspec.Struct, frozen=True):
    """Voice settings: a language such as ``en``, a voice's id or part of its name, words per
    minute, volume 0 to 1.
    """

    language: str
    name: str = ""
    rate: int = 165
    volume: float = 1.0


class Warm(_Line, frozen=True):
    """Prepare for coming jobs, so that they start at once."""

    voicing: Voicing | None = None
    tones: tuple[tuple[Note, ...], ...] = ()


class Say(_Line, frozen=True):
    """Speak. ``job`` is in every reply; ``name`` is a part of the file's name."""

    job: int
    name: str
    text: str
    voicing: Voicing


class Tone(_Line, frozen=True):
    """Play a tone."""

    job: int
    name: str
    notes: tuple[Note, ...]


class Cue(_Line, frozen=True):
    """Play a tone of a prompt ``at`` a time (ns, `host_now`) or as soon as possible after it, and
    after each offset.
    """

    job: int
    hz: float
    ms: float
    at: int
    offsets_ms: tuple[float, ...] = (0.0,)


class Drop(_Line, frozen=True):
    """Leave out what has not begun of a tone of a prompt."""

    job: int


class Reckon(_Line, frozen=True):
    """Report again when a tone of a prompt began, as the clock of the sound card tells now."""

    job: int


class Stop(_Line, frozen=True):
    """Stop this job if it is still under way."""

    job: int


class Examine(_Line, frozen=True):
    """Report the voices and the sound system."""


class Started(_Line, frozen=True):
    """The first samples were fed to the sound card at ``at`` (ns, `host_now`); they last
    ``seconds``.

    ``by``: ``device`` if ``at`` is when they are heard, by the clock of the card.
    """

    job: int
    at: int
    seconds: float
    by: Literal["host", "device"] = "host"


class Ended(_Line, frozen=True):
    """A job ended at ``at``. ``detail``: why it failed; ``at_fault``: false if only its text was
    the reason.
    """

    job: int
    state: Literal["done", "aborted", "failed"]
    at: int
    detail: str = ""
    at_fault: bool = True


class FoundVoice(msgspec.Struct, frozen=True):
    """A voice of the speech engine. Its languages are in lower case, such as ``en-us``."""

    id: str
    name: str = ""
    languages: tuple[str, ...] = ()

    def speaks(self, language: str) -> bool:
        """Return True if the voice speaks a language, in any region."""
        return any(each == language or each.startswith(f"{language}-") for each in self.languages)


class Examined(_Line, frozen=True):
    """The voices and the sound system, or why there are none; the time that a sample waits in the
    card's buffer.
    """

    voices: tuple[FoundVoice, ...] = ()
    no_voices: str = ""
    card: str = ""
    no_card: str = ""
    buffer_ms: float = 0.0


Request = Setup | Warm | Say | Tone | Cue | Drop | Reckon | Stop | Examine
Reply = Started | Ended | Examined

_requests: msgspec.json.Decoder[Request] = msgspec.json.Decoder(Request)
_replies: msgspec.json.Decoder[Reply] = msgspec.json.Decoder(Reply)


def encode(message: Request | Reply) -> bytes:
    """Encode a message as a line."""
    return msgspec.json.encode(message) + b"\n"


def decode_request(line: bytes) -> Request:
    """Decode a request. Raises `msgspec.DecodeError`."""
    return _requests.decode(line)


def decode_reply(line: bytes) -> Reply:
    """Decode a reply. Raises `msgspec.DecodeError`."""
    return _replies.decode(line)
