"""Findings of the checks of ``sar-tui doctor``."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal, NamedTuple

import msgspec

from sar_tui.cli.common import Home

if TYPE_CHECKING:
    from sar_tui.outputs.sound.protocol import Examined


class Finding(msgspec.Struct, frozen=True, rename={"advice": "mend"}):
    """The state of one thing. ``care``: it works, but could work better. ``advice``: what to do
    about it. ``name``: set by the table of checks.
    """

    name: str
    state: Literal["ok", "care", "bad"]
    found: str
    advice: str = ""


def ok(found: str, advice: str = "") -> Finding:
    return Finding("", "ok", found, advice)


def care(found: str, advice: str = "") -> Finding:
    return Finding("", "care", found, advice)


def bad(found: str, advice: str = "") -> Finding:
    return Finding("", "bad", found, advice)


def not_installed(how: str, note: str) -> Finding:
    """Return the finding that an optional package is not installed; the command follows the last
    colon of ``how``.
    """
    return ok(f"not installed. {note}", f"To install it: {how.rpartition(': ')[2]}")


def advised(parts: list[str], note: str) -> Finding:
    """Return the finding of a problem, given in two parts: what was found, and advice."""
    found, *advice = parts
    return care(found, f"{capitalized(''.join(advice))} {note}".strip())


def capitalized(text: str) -> str:
    return text[:1].upper() + text[1:]


class Machine(NamedTuple):
    """The machine and the data that are checked. ``voice`` waits for what the program that speaks
    and plays sounds says of itself; it raises SoundError.
    """

    home: Home
    voice: "Callable[[], Examined]"
