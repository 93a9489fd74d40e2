"""Trying a robot out: whether it is there, how soon it speaks, and how soon it stops."""

import asyncio
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import NamedTuple

import msgspec

from sar_tui.loop.clock import LiveClock
from sar_tui.model.messages import ActionPart, PartState
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.output import Output, OutputError, Report
from sar_tui.outputs.robot import PATIENCE, Robot

STOP_LIMIT_MS = 100.0
"""A stop should be confirmed within this time."""
_BEFORE_STOP_S = 0.3
"""Time for which it speaks or moves before it is stopped."""
_SILENT_S = 1.0
"""Time after which it is stopped although it has not said that it began."""
_STOPPED_S = 2.5
_POLL_S = 0.005
_OVER: tuple[PartState, ...] = ("done", "aborted", "failed")


class Tried(msgspec.Struct, frozen=True):
    """A part that a robot was asked for. ``detail``: why it failed or was skipped."""

    state: PartState
    started_ms: float | None
    """Time from the request to its start; None if it did not start."""
    ended_ms: float
    detail: str = ""


class Stopped(msgspec.Struct, frozen=True):
    """A stop. ``took_ms``: until the robot confirmed it; None if it did not."""

    took_ms: float | None
    detail: str = ""


class Examined(msgspec.Struct, frozen=True):
    """The findings about a robot. ``None``: it was not tried.

    Attributes:
        address: its address.
        reachable: whether it is connected.
        connected_ms: time until it was; None if it was not.
        said: the sentence.
        moved: the gesture.
        stopped: the stop of another sentence, or of another gesture if it does not speak; also None
            if that ended before.
        problems: what is wrong, one sentence each.
    """

    address: str
    reachable: bool
    connected_ms: float | None = None
    said: Tried | None = None
    moved: Tried | None = None
    stopped: Stopped | None = None
    problems: tuple[str, ...] = ()


class What(NamedTuple):
    """A sentence and a gesture to try; neither, to see only whether the robot is there."""

    say: str = ""
    gesture: str = ""


async def examine(
    address: str, output: Output, theme: Theme, what: What, tell: Callable[[str], object]
) -> Examined:
    """Open an output, have it speak, move and stop, and close it.

    ``tell`` is called with what comes next. Nothing is waited for without a limit, except for the
    end of a part, for which an output has limits of its own.
    """
    clock = LiveClock(asyncio.get_running_loop())
    run = asyncio.create_task(clock.run())
    trial = _Trial(output, clock)
    try:
        return await trial.examine(address, theme, what, tell)
    finally:
        output.close()
        run.cancel()
        with suppress(asyncio.CancelledError):
            await run


class _Trial:
    """An output that is tried out, and its reports."""

    def __init__(self, output: Output, clock: LiveClock) -> None:
        self._output, self._clock = output, clock
        self._reports: list[Report] = []

    async def examine(
        self, address: str, theme: Theme, what: What, tell: Callable[[str], object]
    ) -> Examined:
        output = self._output
        began = self._clock.now()
        output.open(theme, self._clock, self._reports.append)
        if isinstance(output, Robot):
            await self._until(lambda: output.is_ready, PATIENCE / SECOND)
            if not output.is_ready:
                return Examined(address, False, problems=(output.absence,))
        found = Examined(address, True, (self._clock.now() - began) / MS)
        stops: ActionPart = "gesture"
        if what.say and "say" in output.can:
            tell(f"It says: {what.say}")
            said = await self._try("say", what.say)
            found = msgspec.structs.replace(found, said=said)
            stops = stops if said.started_ms is None else "say"
        if what.gesture and "gesture" in output.can:
            tell(f"It moves: {what.gesture}")
            moved = await self._try("gesture", what.gesture)
            found = msgspec.structs.replace(found, moved=moved)
            if moved.state == "failed" and not isinstance(output, Robot):  # no connection to ask
                return Examined(address, False, moved=moved, problems=_problems(found))
        if what.say or what.gesture:
            tell("It begins again, and is stopped.")
            again = " ".join([what.say] * 3) if stops == "say" else what.gesture
            stopped = await self._stop(stops, again) if stops in output.can and again else None
            found = msgspec.structs.replace(found, stopped=stopped)
        return msgspec.structs.replace(found, problems=_problems(found))

    async def _try(self, part: ActionPart, what: str) -> Tried:
        """Request a part, and wait for its end."""
        asked = self._request(f"try-{part}", part, what)
        await self._until(lambda: self._end(f"try-{part}") is not None)
        started, end = self._start(f"try-{part}"), self._end(f"try-{part}")
        assert end
        at = None if started is None else (started.at - asked) / MS
        return Tried(end.state, at, (end.at - asked) / MS, end.detail)

    async def _stop(self, part: ActionPart, what: str) -> Stopped | None:
        """Request a part, and stop it when it is under way; None if it ended before."""
        self._request("stop", part, what)
        await self._until(lambda: bool(self._start("stop") or self._end("stop")), _SILENT_S)
        await asyncio.sleep(_BEFORE_STOP_S)
        if self._end("stop"):
            return None
        asked = self._clock.now()
        try:
            self._output.stop()
        except OutputError as error:
            return Stopped(None, str(error))
        await self._until(lambda: self._end("stop") is not None, _STOPPED_S)
        end = self._end("stop")
        if end is None:
            return Stopped(None, "It did not report the end.")
        is_confirmed = end.state in ("done", "aborted") and not end.detail
        return Stopped((end.at - asked) / MS if is_confirmed else None, end.detail)

    def _request(self, action: str, part: ActionPart, what: str) -> int:
        asked = self._clock.now()
        getattr(self._output, part)(action, what)
        return asked

    def _start(self, action: str) -> Report | None:
        return self._first(action, ("started",))

    def _end(self, action: str) -> Report | None:
        return self._first(action, _OVER)

    def _first(self, action: str, states: Sequence[PartState]) -> Report | None:
        reports = list(self._reports)
        return next((r for r in reports if r.action == action and r.state in states), None)

    async def _until(self, happened: Callable[[], bool], seconds: float = 600.0) -> None:
        until = self._clock.now() + round(seconds * SECOND)
        while not happened() and self._clock.now() < until:
            await asyncio.sleep(_POLL_S)


def _problems(found: Examined) -> tuple[str, ...]:
    problems = [
        tried.detail or "It broke off."
        for tried in (found.said, found.moved)
        if tried and (tried.state != "done" or tried.detail)
    ]
    if stopped := found.stopped:
        if stopped.took_ms is None:
            problems.append(f"The stop was not confirmed. {stopped.detail}".strip())
        elif stopped.took_ms > STOP_LIMIT_MS:
            problems.append(
                f"The stop was confirmed after {stopped.took_ms:.0f} ms, later than "
                f"{STOP_LIMIT_MS:.0f} ms."
            )
    return tuple(dict.fromkeys(problems))
