"""What the program and its voice, the child process that sounds, tell each other: one JSON line a message."""

from typing import Literal

import msgspec

from sar_tui.framework.theme import Note


class SoundError(ValueError):
    """Something cannot be sounded; one or two sentences for a person."""


class Unreadable(SoundError):
    """It is the text that cannot be spoken, and not the engine that is at fault."""


class _Line(msgspec.Struct, frozen=True, tag_field="is", tag=str.lower):
    """One message."""


class Setup(_Line, frozen=True):
    """The first message. Sounds go to ``folder`` as WAV files, or where that is empty to the sound card.

    ``backends``: the sound systems to try, by miniaudio's names; all real ones if empty. Where ``in_real_time`` is
    false, nothing is heard, and each sound ends as it begins: the program lets its own clock pass.
    """

    folder: str = ""
    backends: tuple[str, ...] = ()
    in_real_time: bool = True


class Voicing(msgspec.Struct, frozen=True):
    """How to speak: a language like ``en``, the id of a voice or a part of its name, words a minute, 0 to 1."""

    language: str
    name: str = ""
    rate: int = 165
    volume: float = 1.0


class Warm(_Line, frozen=True):
    """Get ready for what is to come, so that it begins at once."""

    voicing: Voicing | None = None
    tones: tuple[tuple[Note, ...], ...] = ()


class Say(_Line, frozen=True):
    """Speak. ``job`` is in every reply; ``name`` is a part of the file's name."""

    job: int
    name: str
    text: str
    voicing: Voicing


class Tone(_Line, frozen=True):
    """Sound a tone."""

    job: int
    name: str
    notes: tuple[Note, ...]


class Stop(_Line, frozen=True):
    """Be still, if that job is still under way."""

    job: int


class Examine(_Line, frozen=True):
    """Tell what there is to speak and to sound with."""


class Started(_Line, frozen=True):
    """The first samples have been fed to the sound card at ``at`` (ns, `host_now`); they last for ``seconds``."""

    job: int
    at: int
    seconds: float


class Ended(_Line, frozen=True):
    """A job is over since ``at``. ``detail`` says why it failed; ``at_fault`` is false where only the text was."""

    job: int
    state: Literal["done", "aborted", "failed"]
    at: int
    detail: str = ""
    at_fault: bool = True


class FoundVoice(msgspec.Struct, frozen=True):
    """A voice of the speech engine; its languages in lower case, like ``en-us``."""

    id: str
    name: str = ""
    languages: tuple[str, ...] = ()

    def speaks(self, language: str) -> bool:
        """Whether it speaks a language, in whatever region."""
        return any(each == language or each.startswith(f"{language}-") for each in self.languages)


class Examined(_Line, frozen=True):
    """What there is: voices and a sound system, or why there are none."""

    voices: tuple[FoundVoice, ...] = ()
    no_voices: str = ""
    card: str = ""
    no_card: str = ""


Request = Setup | Warm | Say | Tone | Stop | Examine
Reply = Started | Ended | Examined

_requests: msgspec.json.Decoder[Request] = msgspec.json.Decoder(Request)
_replies: msgspec.json.Decoder[Reply] = msgspec.json.Decoder(Reply)


def line(message: Request | Reply) -> bytes:
    """A message as a line."""
    return msgspec.json.encode(message) + b"\n"


def request(line: bytes) -> Request:
    """What a line asks for. Raises `msgspec.DecodeError` for one that is none."""
    return _requests.decode(line)


def reply(line: bytes) -> Reply:
    """What a line answers. Raises `msgspec.DecodeError` for one that is none."""
    return _replies.decode(line)
