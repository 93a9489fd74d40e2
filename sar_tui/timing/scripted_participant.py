"""A scripted participant at a pseudo-terminal, who reads a prompt, waits as planned, and presses a
key.

Its own time stamps give the true reaction times, with which recorded ones are compared.
"""

import re
import time
from collections.abc import Callable

import msgspec

from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.units import MS, SECOND
from sar_tui.timing.pty import Terminal

Answer = Callable[[int, str], tuple[float, str]]
"""Maps a prompt's number (0, 1, …) and the key it asks for to a delay in ms and a key to press."""

SILENCE = 800 * MS
"""Enter is pressed when it was requested and nothing has been drawn for this time."""
LONGEST_SILENCE_WAIT = 1500 * MS
"""Enter is pressed this time after the request even if something on the screen keeps moving."""
SPIN = 1 * MS
"""Duration of the busy loop at the end of a wait, which is more exact than sleeping."""

_PROMPT = re.compile(rb"Press: ([^\x00-\x20\x7f]+)(?=[\x00-\x20\x7f])")
_ENTER = re.compile(rb"(?:\x1b\[[\d;]*m|\b)Enter\b")


class Press(msgspec.Struct, frozen=True):
    """The response to one prompt.

    Args:
        expected: the key that the prompt asked for.
        key: the key that was pressed.
        onset: when the prompt's bytes were read, in ns of ``time.monotonic_ns``.
        response: just before the key was written, on the same clock.
    """

    expected: str
    key: str
    onset: int
    response: int

    @property
    def reaction_time_ms(self) -> float:
        """The true reaction time."""
        return (self.response - self.onset) / MS


class NoPrompt(TimeoutError):
    """The program did not show a prompt or ask for Enter for too long."""


def random_answers(
    seed: int, shortest_ms: float, longest_ms: float, error_rate: float = 0.0
) -> Answer:
    """Return a source of responses with uniform delays, a share of them wrong. Equal seeds give
    equal responses.
    """

    def answer(number: int, expected: str) -> tuple[float, str]:
        streams = RandomStreams(seed, number)
        delay = shortest_ms + streams.uniform("delay") * (longest_ms - shortest_ms)
        if streams.uniform("slip") < error_rate:
            return delay, streams.choice([key for key in "asdfjkl" if key != expected], "key")
        return delay, expected

    return answer


class ScriptedParticipant:
    """Responds to prompts such as ``Press: f`` or ``Press: left``, and presses Enter when the
    screen requests it.

    A prompt must be one unbroken run of plain text. It is new if its line comes after the last
    response, so that a prompt can be repeated.

    Args:
        terminal: the terminal that shows the prompts.
        answer: decides on delays and keys.
        guard_ms: a prompt line within this time of a response is the old one, drawn again.

    Attributes:
        presses: the prompts answered so far.
    """

    def __init__(self, terminal: Terminal, answer: Answer, *, guard_ms: float = 40) -> None:
        self.terminal = terminal
        self.presses: list[Press] = []
        self._answer = answer
        self._guard = round(guard_ms * MS)
        self._guarded_until = 0
        self._prompts_from = 0
        self._enter_from = 0
        self._asked_at: int | None = None
        self._due: tuple[int, int, str, str] | None = (
            None  # time to press, onset, expected key, key to press
        )

    def run(
        self, prompts: int | None = None, *, until: int | None = None, patience_s: float = 60
    ) -> list[Press]:
        """Respond until there are this many responses in total, or until a time (ns), or until the
        program ends.

        Raises:
            NoPrompt: nothing was asked for ``patience_s`` seconds.
        """
        patience = round(patience_s * SECOND)
        deadline = time.monotonic_ns() + patience
        if self._due is None:
            self._find_prompt()  # somebody else may have read it
        while (prompts is None or len(self.presses) < prompts) and not self.terminal.ended:
            now = time.monotonic_ns()
            if until is not None and now >= until:
                break
            if now >= deadline:
                raise NoPrompt(
                    f"There was no prompt and no request for Enter for {patience_s:g} s."
                )
            if self._act(min(deadline, until or deadline)):
                deadline = time.monotonic_ns() + patience
        return self.presses

    def _act(self, until: int) -> bool:
        """Press the key that is due, or read the screen. Return True if a key was pressed."""
        if self._due is not None:
            return self._wait_and_press(*self._due, until)
        enter_at = until
        if self._asked_at is not None:
            enter_at = min(self.terminal.read_at + SILENCE, self._asked_at + LONGEST_SILENCE_WAIT)
            if time.monotonic_ns() >= enter_at:
                self.terminal.press("enter")
                self.forget_enter()
                return True
        if self.terminal.read(min(enter_at, until)):
            self._find_prompt()
        return False

    def forget_enter(self) -> None:
        """Ignore earlier requests for Enter: somebody else has pressed it."""
        self._enter_from, self._asked_at = len(self.terminal.output), None

    def _find_prompt(self) -> None:
        """Look for a prompt or a request for Enter in the new output."""
        onset = self.terminal.read_at
        prompt = _PROMPT.search(self.terminal.output, self._prompts_from)
        if self._asked_at is None and _ENTER.search(self.terminal.output, self._enter_from):
            self._asked_at = onset
        if prompt is None:
            return
        self._prompts_from = prompt.end()
        if onset >= self._guarded_until:
            expected = prompt[1].decode()
            delay, key = self._answer(len(self.presses), expected)
            self._due = onset + round(delay * MS), onset, expected, key

    def _wait_and_press(self, due: int, onset: int, expected: str, key: str, until: int) -> bool:
        while time.monotonic_ns() < due - SPIN:
            if time.monotonic_ns() >= until or self.terminal.ended:
                return False
            self.terminal.read(min(due - SPIN, until))
        if self.terminal.ended:
            return False
        while time.monotonic_ns() < due:
            pass
        response = self.terminal.press(key)
        self.presses.append(Press(expected=expected, key=key, onset=onset, response=response))
        self._due = None
        self._guarded_until = response + self._guard
        self._prompts_from = len(self.terminal.output)
        self.forget_enter()
        return True
