"""A robot that is reached over a network, as an output: what waits, what is under way, and what a
stop has ended. `ros`, `ros4hri`, `furhat` and `reachy` are such robots, each with a `Link` of its
own.
"""

import secrets
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import ClassVar, NamedTuple, Protocol, TypeVar, cast

import msgspec

from sar_tui.drivers.address import Address, AddressError, parse
from sar_tui.loop.clock import Clock, Handle
from sar_tui.model.gesture import Gesture
from sar_tui.model.messages import ActionPart, PartState
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.model.visible_text import visible
from sar_tui.outputs.output import Output, OutputError, Report

T = TypeVar("T", bound=msgspec.Struct)

PATIENCE = 3 * SECOND
"""Time after opening in which a request may wait for the first connection."""
ANSWER = 2 * SECOND
"""Time in which a robot must report that it has started."""
CONFIRM = 100 * MS
"""Time in which it must confirm a stop."""
LONGEST = 15 * SECOND
"""Time that a request may take beyond its expected duration."""
A_CHARACTER = 100 * MS
"""Slowest speaking rate: time for one character."""


class Request:
    """A request to the robot.

    Attributes:
        id: identifies its action to the robot. It is unique to this session, so late answers to
            others are ignored.
        part: what it is about: ``say``, ``gesture`` or ``gaze``.
        what: the text, the gesture's name, or the direction.
        theme: gives the language, the voice and the keyframes.
        lasts: the expected duration, in ns.
        answer: time in which the robot must report that it has started, in ns.
    """

    def __init__(
        self, action: str, id: str, part: ActionPart, what: str, theme: Theme, lasts: int
    ) -> None:
        self.action, self.id, self.part, self.what = action, id, part, what
        self.theme, self.lasts = theme, lasts
        self.answer = ANSWER
        self.sent: int | None = None
        self.started: int | None = None
        self.is_stopping = False
        self.timer: Handle | None = None

    @property
    def gesture(self) -> Gesture:
        """The theme's gesture of this name."""
        return self.theme.gestures[self.what]


class Skipped(Exception):
    """The robot has nothing for a request. The message is a sentence for the log."""


class OwnNames(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The robot's own names of gestures, as options of its address; empty: the robot has none."""

    nod: str = ""
    shake: str = ""
    cheer: str = ""
    wave: str = ""
    point_left: str = ""
    point_right: str = ""
    lean_in: str = ""
    rest: str = ""

    def of(self, gesture: str) -> str:
        """Return the robot's name of one of the theme's gestures.

        Raises:
            Skipped: the robot has none.
        """
        name: str = getattr(self, gesture, "")
        if not name:
            raise Skipped(f"This robot has no gesture for {gesture}.")
        return name


class Answer(NamedTuple):
    """A robot's report on a request. Without a part, it is about all parts of that id; without an
    id, about the request that has been under way for longest.
    """

    state: PartState
    id: str = ""
    part: str = ""
    detail: str = ""


class Link(Protocol):
    """The connection to a robot. Nothing in it waits for the robot, and it reconnects by itself.

    It is made with two functions, to be called from any thread: one after the connection was made
    or lost, one with each `Answer`, or with the reason why one cannot be read.
    """

    @property
    def problem(self) -> str:
        """Why a connection is impossible, as a sentence; empty if it is possible."""
        ...

    @property
    def is_connected(self) -> bool:
        """True if the robot is connected, as far as is known."""
        ...

    def open(self) -> None:
        """Connect in the background, and stay connected."""
        ...

    def send(self, request: Request) -> bool:
        """Send a request. Returns False without a connection.

        Raises:
            Skipped: the robot has nothing for it, such as a gesture that it does not know.
            OutputError: the robot cannot do it at present.
        """
        ...

    def stop(self, id: str) -> bool:
        """Have the robot stop what has this id; everything if it is empty. Returns False without a
        connection.
        """
        ...

    def close(self) -> None:
        """Disconnect. May be called twice."""
        ...


Changed = Callable[[], None]
Heard = Callable[[Answer | str], None]


class Robot(Output, ABC):
    """A robot that speaks, moves and looks. Subclasses say where it is and connect to it.

    Everything except sending happens on the clock's thread. The next request of a part is sent when
    the one before is over.
    """

    can = frozenset[ActionPart]({"say", "gesture", "gaze"})
    place: str
    """Its place in sentences: ``192.0.2.7, port 9090``."""
    missing: str
    """Clause that says, without a connection, what is not there, and what to do."""
    settle: ClassVar[int] = 0
    """Pause after connecting before anything is sent, in ns."""
    confirm: ClassVar[int] = CONFIRM
    """Time in which the robot must confirm a stop, in ns. Less than `node.STOP_TIMEOUT`."""
    lanes: ClassVar[Mapping[ActionPart, str]] = {}
    """Parts that wait for each other, by the same name: they move the same joints."""

    @abstractmethod
    def connect(self, changed: Changed, heard: Heard) -> Link:
        """Make the connection; it is opened afterwards."""

    _link: Link | None = None

    @property
    def is_ready(self) -> bool:
        """True once the robot is connected, and requests are sent at once."""
        ready_at = self._ready_at if self._link else None
        return ready_at is not None and self.clock.now() >= ready_at

    @property
    def absence(self) -> str:
        """Why the robot is not connected, as a sentence."""
        return (self._link.problem if self._link else "") or self._not_connected

    def open(self, theme: Theme, clock: Clock, report: Callable[[Report], None]) -> None:
        """Connect in the background. Requests in the first moments wait for the connection."""
        self.close()
        super().open(theme, clock, report)
        self._queues: dict[str, deque[Request]] = {
            self._lane(part): deque[Request]() for part in sorted(self.can)
        }
        self._token = secrets.token_hex(3)
        self._ready_at: int | None = None
        self._stop_pending = self._was_lost = False
        self._unended: dict[ActionPart, Request] = {}
        self._unread = ""
        self._patience = clock.now() + PATIENCE
        link = self.connect(
            lambda: self._on_change(link), lambda answer: self._on_answer(link, answer)
        )
        self._link = link
        link.open()
        self._advance_at(link, self._patience)

    def say(self, action: str, text: str) -> None:
        """Have the robot speak."""
        text = text.encode("utf-8", "replace").decode()  # lone surrogates cannot be sent
        self._request(action, "say", text, A_CHARACTER * len(text))

    def gesture(self, action: str, name: str) -> None:
        """Have the robot perform one of the theme's gestures."""
        gesture = self.theme.gestures.get(name)
        if gesture is None:
            why = f"The theme {self.theme.name} has no gesture {plain(name)}."
            self.report(action, "gesture", "failed", why)
        else:
            self._request(action, "gesture", name, gesture.duration_ms * MS)

    def gaze(self, action: str, where: str) -> None:
        """Have the robot look somewhere."""
        self._request(action, "gaze", where, 0)

    def stop(self, action: str = "") -> None:
        """Have the robot stop. Its request is aborted when it confirms, or after a while as not
        confirmed.

        The next request waits for that. A stop that cannot be sent now is sent before anything
        else. Raises OutputError if the robot may still be performing a request that was given up.
        """
        if self._link is None:
            return
        stopped = [
            request
            for queue in self._queues.values()
            for request in queue
            if action in ("", request.action)
        ]
        sent = [request for request in stopped if request.sent is not None]
        is_sent = False
        if sent or not action:
            is_sent = self._link.stop(action and self._id(action))
            self._stop_pending |= not is_sent
        now = self.clock.now()
        for request in stopped:
            if request.sent is None:
                self._end(request, "aborted", now)
            elif not is_sent:
                self._end(request, "failed", now, self._stop_failure)
            elif not request.is_stopping:
                request.is_stopping = True
                self._set_timer(
                    request, now + self.confirm, partial(self._overdue, self._link, request)
                )
        if action:
            self._advance_all(self._link)
        elif self._was_lost and not is_sent:
            raise OutputError(self._stop_failure)
        elif not sent and any(self._may_go_on(request, now) for request in self._unended.values()):
            raise OutputError(self._unconfirmed)

    def close(self) -> None:
        """Have the robot stop, and close the connection."""
        if self._link is not None:
            with suppress(OutputError):  # nothing is reported any more
                self.stop()
            link, self._link = self._link, None
            link.close()

    # --- on the connection's thread: stamp and pass on

    def _on_change(self, link: Link) -> None:
        self.clock.call_soon(partial(self._connection_changed, link, link.is_connected))

    def _on_answer(self, link: Link, answer: Answer | str) -> None:
        at = self.clock.now()
        if isinstance(answer, str):
            self._unread = f" One of its reports could not be understood: {answer}."
        else:
            self.clock.call_soon(partial(self._answered, link, answer, at))

    # --- on the clock's thread

    def _connection_changed(self, link: Link, connected: bool) -> None:
        if link is not self._link:
            return
        now = self.clock.now()
        if connected:
            self._was_lost = False
            if self._stop_pending:
                self._stop_pending = not link.stop("")
            self._ready_at = now + self.settle
            self._advance_at(link, self._ready_at)
            return
        self._ready_at = None
        for request in self._under_way:
            self._was_lost = True
            self._stop_pending |= request.is_stopping
            self._unended[request.part] = request
            self._end(
                request, "failed", now, f"The connection to the robot at {self.place} was lost."
            )
        self._advance_all(link)

    def _answered(self, link: Link, answer: Answer, at: int) -> None:
        if link is not self._link:
            return
        about = [
            request
            for request in self._under_way
            if request.sent is not None and request.sent <= at and _is_about(answer, request)
        ]
        self._forget_unended(answer, {request.part for request in about})
        begun = [request for request in about if request.started is not None]
        waiting = [request for request in about if request.started is None]
        for request in (waiting if answer.state == "started" else begun + waiting)[:1]:
            if request.started is None and answer.state in ("started", "done"):
                request.started = at
                self._report(request, "started", at)
            if answer.state != "started":
                detail = plain(answer.detail)
                why = detail or ("The robot failed." if answer.state == "failed" else "")
                if request.is_stopping and not why:
                    self._unended.clear()
                self._end(
                    request, "aborted" if request.is_stopping and not why else answer.state, at, why
                )
                self._advance(request.part)

    def _forget_unended(self, answer: Answer, parts: set[ActionPart]) -> None:
        """Forget requests that were given up and are over now: the robot reports so late, or has
        begun the next one.
        """
        self._unended = {
            part: request
            for part, request in self._unended.items()
            if part not in parts and (answer.state == "started" or not _is_about(answer, request))
        }

    def _request(self, action: str, part: ActionPart, what: str, lasts: int) -> None:
        if self._link is not None:
            queue = self._queues[self._lane(part)]
            queue.append(Request(action, self._id(action), part, what, self.theme, lasts))
            self._advance(part)

    def _advance_at(self, link: Link, when: int) -> None:
        self.clock.call_at(when, partial(self._advance_all, link, when))

    def _advance_all(self, link: Link, due: int = 0) -> None:
        if link is self._link:
            for part in sorted(self.can):
                self._advance(part, due)

    def _advance(self, part: ActionPart, due: int = 0) -> None:
        """Send the next requests of a part that are due, or fail them. The time is at least
        ``due``.
        """
        queue, link = self._queues[self._lane(part)], cast(Link, self._link)
        while queue and queue[0].sent is None:
            request, now = queue[0], max(self.clock.now(), due)
            if not link.problem and self._is_to_wait(link, now):
                return
            try:
                is_sent = link.send(request)
            except Skipped as nothing:
                self._report(request, "started", now)
                self._end(request, "done", now, str(nothing))
            except OutputError as error:
                self._end(request, "failed", now, str(error))
            else:
                if is_sent:
                    request.sent, self._unread = now, ""
                    self._set_timer(
                        request, now + request.answer, partial(self._overdue, link, request)
                    )
                else:
                    self._end(request, "failed", now, self.absence)

    def _is_to_wait(self, link: Link, now: int) -> bool:
        if self._ready_at is None:
            # if it is connected, `_connection_changed` has yet to be called
            return link.is_connected or now < self._patience
        return now < self._ready_at

    def _overdue(self, link: Link, request: Request) -> None:
        queue, now = self._queues[self._lane(request.part)], self.clock.now()
        if link is not self._link or not queue or queue[0] is not request:
            return
        state: PartState = "failed"
        if request.is_stopping:
            state, why = "aborted", self._unconfirmed
        elif request.started is None:
            why = f"Sent to the robot at {self.place}, which did not acknowledge it."
        elif now < (until := request.started + request.lasts + LONGEST):
            self._set_timer(request, until, partial(self._overdue, link, request))
            return
        else:
            why = f"The robot at {self.place} started, but did not report that it was done."
        self._unended[request.part] = request
        self._end(request, state, now, why + self._unread)
        self._advance(request.part)

    def _set_timer(self, request: Request, when: int, ring: Callable[[], None]) -> None:
        if request.timer:
            request.timer.cancel()
        request.timer = self.clock.call_at(when, ring)

    def _end(self, request: Request, state: PartState, at: int, detail: str = "") -> None:
        self._queues[self._lane(request.part)].remove(request)
        if request.timer:
            request.timer.cancel()
        self._report(request, state, at, detail)

    def _report(self, request: Request, state: PartState, at: int, detail: str = "") -> None:
        self._send_report(Report(request.action, request.part, state, at, detail))

    # --- helpers

    def _lane(self, part: ActionPart) -> str:
        return self.lanes.get(part, part)

    def _id(self, action: str) -> str:
        return f"{action}-{self._token}"

    @property
    def _under_way(self) -> list[Request]:
        """Requests that are sent and not over, oldest first."""
        sent = (queue[0] for queue in self._queues.values() if queue and queue[0].sent is not None)
        return sorted(sent, key=lambda request: request.sent or 0)

    def _may_go_on(self, request: Request, now: int) -> bool:
        """Return True if the robot may perform a request that was given up: it started it, or still
        has time to.
        """
        return request.started is not None or now < (request.sent or 0) + request.lasts + LONGEST

    @property
    def _unconfirmed(self) -> str:
        return f"The robot at {self.place} did not confirm that it stopped."

    @property
    def _stop_failure(self) -> str:
        return f"The robot could not be asked to stop. {self._not_connected}"

    @property
    def _not_connected(self) -> str:
        return f"The robot is not connected: {self.missing}"


def _is_about(answer: Answer, request: Request) -> bool:
    return answer.id in ("", request.id) and answer.part in ("", request.part)


def plain(text: object) -> str:
    """Return a robot's text, fit for one line of the log and the screen."""
    return visible(str(text))[:200]


def read_address(
    address: str, scheme: str, port: int, options: type[T], example: str
) -> tuple[Address, T]:
    """Read the address of a robot, and its options.

    Raises:
        OutputError: it is not valid; the message has the example.
    """
    try:
        found = parse(address, scheme, port, example)
        chosen = msgspec.convert(found.options, options, strict=False)
    except AddressError as error:
        raise OutputError(str(error)) from error
    except msgspec.ValidationError as error:
        raise OutputError(
            f'The address "{address}" is not valid ({error}). Use {example}.'
        ) from error
    if found.path.strip("/"):
        raise OutputError(
            f'"{found.path}" has no meaning in the address of a robot. Use {example}.'
        )
    return found, chosen
