"""Outputs by name: the included ones, and those of plug-ins (entry points of the group
``sar_tui.outputs``).
"""

import difflib
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, get_args

from sar_tui.model.language import Sentence
from sar_tui.model.messages import ActionPart
from sar_tui.model.theme import TONES, Theme
from sar_tui.outputs.node import OutputNode
from sar_tui.outputs.output import Output, OutputError
from sar_tui.plugin_loader import Group

if TYPE_CHECKING:
    from sar_tui.outputs.sound.mixer import Sound

INSTALLED = Group("sar_tui.outputs", "output", OutputError)
SCREEN = "screen"
"""The face and the text on the screen. The app makes this output itself."""
_NO_OUTPUT = 'There is no output "{kind}". Choose one of: {known}.'
_checked: dict[tuple[str, str], tuple[object, Output]] = {}
"""Outputs that plug-ins made for a check, with their factory: reused on opening, as making one may
take time.
"""


def output_names() -> list[str]:
    """Return the names that ``open_outputs`` knows. Each output defines the text after the
    colon.
    """
    return sorted({SCREEN, *_SHIPPED, *INSTALLED.names()})


def check_outputs(addresses: Sequence[str], speech: str = "sound") -> None:
    """Raise OutputError, with one clear sentence, for an address that is unknown, invalid or used
    twice.
    """
    kinds = [_split(address)[0] for address in addresses]
    for kind in kinds:
        if kind not in (known := output_names()):
            near = difflib.get_close_matches(kind, known, 1)
            text = (
                'There is no output "{kind}". Did you mean {near}? Choose one of: {known}.'
                if near
                else _NO_OUTPUT
            )
            raise OutputError(Sentence(text, kind=kind, near="".join(near), known=tuple(known)))
        if kinds.count(kind) > 1:
            raise OutputError(Sentence("The output {kind} is named twice.", kind=kind))
    from sar_tui.outputs.sound.mixer import check_sound
    from sar_tui.outputs.sound.protocol import SoundError

    try:
        check_sound(speech)
    except SoundError as error:
        raise OutputError(str(error)) from error
    _make(addresses, speech, keep=True)


def open_outputs(addresses: Sequence[str], speech: str, theme: Theme) -> list[OutputNode]:
    """Return the nodes of a session's outputs, except the screen's.

    - ``speech``: the voice; the setting ``speech`` says where it goes (``sound``, ``file:FOLDER``);
    - ``tones``, ``tones:go+end+success``: short tones, to the same place;
    - ``servo``, ``servo:SERIAL?...``: gestures by RC servos on a Phidget controller;
    - ``ros://HOST:PORT...``: a robot on a ROS system, over rosbridge;
    - ``ros4hri://HOST:PORT...``: one with ROS4HRI skills, over rosbridge;
    - ``furhat://HOST:PORT...``, ``reachy://HOST:PORT``: a Furhat, a Reachy Mini;
    - any other: the entry point of that name, called with the text after the colon.

    Raises:
        OutputError: an address is invalid, or a plug-in cannot be loaded.
    """
    return [
        OutputNode(output, address, theme, cues)
        for output, address, cues in _make(addresses, speech)
    ]


def _make(
    addresses: Sequence[str], speech: str, keep: bool = False
) -> list[tuple[Output, str, tuple[str, ...]]]:
    from sar_tui.outputs.sound.mixer import Sound

    for forgotten in _checked.keys() - {_split(address) for address in addresses}:
        del _checked[forgotten]
    made: list[tuple[Output, str, tuple[str, ...]]] = []
    sound = Sound(speech)  # shared, so that tones and speech never overlap
    # tones before speech
    for address in sorted(addresses, key=lambda address: _split(address)[0] != "tones"):
        kind, text = _split(address)
        if kind == SCREEN and text:
            problem = 'The screen has nothing after its name; it was given "{text}".'
            raise OutputError(Sentence(problem, text=text))
        if kind in _SHIPPED:
            made.append(
                (_SHIPPED[kind](text, sound), address, _cues(text) if kind == "tones" else ())
            )
        elif kind != SCREEN:
            made.append((_plugged_in(kind, text), address, ()))
    _check_names(made, [SCREEN] if SCREEN in addresses else [])
    if not keep:
        _checked.clear()
    return made


def _check_names(made: list[tuple[Output, str, tuple[str, ...]]], taken: list[str]) -> None:
    """Raise OutputError if two outputs have the same name, which identifies an output in the
    log.
    """
    for output, address, _ in made:
        if output.name in taken:
            raise OutputError(
                f'Another output is called "{output.name}" as well as {address}: leave one of '
                "them out."
            )
        taken.append(output.name)


def _split(address: str) -> tuple[str, str]:
    kind, _, text = address.strip().partition(":")
    return kind, text


def _cues(text: str) -> tuple[str, ...]:
    """Return the tones in an address; all of them if it names none."""
    cues = tuple(filter(None, text.split("+"))) or TONES
    for cue in cues:
        if cue not in TONES:
            problem = 'There is no tone "{cue}". Choose one of: {known}.'
            raise OutputError(Sentence(problem, cue=cue, known=tuple(TONES)))
    return cues


def _plugged_in(kind: str, text: str) -> Output:
    def made(make: Callable[[str], object]) -> Output:
        made_by, output = _checked.get((kind, text), (None, None))
        checked = output if made_by is make and output else _checked_output(kind, make(text))
        _checked[kind, text] = make, checked
        return checked

    found: Output | None = INSTALLED.load(kind, made)
    if found is None:
        raise OutputError(Sentence(_NO_OUTPUT, kind=kind, known=tuple(output_names())))
    return found


def _checked_output(kind: str, output: object) -> Output:
    """Return what a plug-in made. Raises OutputError if it is no output."""
    if not isinstance(output, Output):
        raise OutputError(f"The output {kind} is not an Output.")
    if not isinstance(name := getattr(output, "name", ""), str) or not name:
        raise OutputError(f"The output {kind} has no name.")
    parts = get_args(ActionPart)
    if not isinstance(output.can, frozenset | set) or not output.can <= set(parts):
        raise OutputError(
            f"The can of the output {kind} is not a frozenset of: {', '.join(parts)}."
        )
    return output


def _speech(text: str, sound: "Sound") -> Output:
    from sar_tui.outputs.speech import Speech

    if text:
        problem = 'Speech has nothing after its name; "{text}" belongs to the setting speech.'
        raise OutputError(Sentence(problem, text=text))
    return Speech(sound)


def _tones(_: str, sound: "Sound") -> Output:
    from sar_tui.outputs.speech import Tones

    return Tones(sound)


def _servo(text: str, _: "Sound") -> Output:
    from sar_tui.outputs.servo.servo import Servo

    return Servo(text)


def _ros(text: str, _: "Sound") -> Output:
    from sar_tui.outputs.ros import Ros

    return Ros(text)


def _ros4hri(text: str, _: "Sound") -> Output:
    from sar_tui.outputs.ros4hri import Ros4Hri

    return Ros4Hri(text)


def _furhat(text: str, _: "Sound") -> Output:
    from sar_tui.outputs.furhat import Furhat

    return Furhat(text)


def _reachy(text: str, _: "Sound") -> Output:
    from sar_tui.outputs.reachy import Reachy

    return Reachy(text)


_SHIPPED: dict[str, Callable[[str, "Sound"], Output]] = {
    "speech": _speech,
    "tones": _tones,
    "servo": _servo,
    "ros": _ros,
    "ros4hri": _ros4hri,
    "furhat": _furhat,
    "reachy": _reachy,
}
