"""The node of an output: each part is reported once as over, whatever the output does."""

import threading
from types import SimpleNamespace
from typing import Any, ClassVar

import msgspec
import pytest

from sar_tui.loop import topics as t
from sar_tui.loop.bus import FAULT, Bus, Topic
from sar_tui.loop.clock import PacedClock, VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.model import messages as m
from sar_tui.model.messages import ActionPart
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.node import PER_CHARACTER, STOP_TIMEOUT, TIMEOUT, OutputNode
from sar_tui.outputs.output import Output, OutputError, Report
from tests.outputs.contract import THEME as PLAIN_THEME
from tests.outputs.contract import host_clock
from tests.outputs.fake_outputs import EVERYTHING, FakeOutput

LASTING: tuple[ActionPart, ...] = ("say", "gesture", "gaze", "tone")


class Sent(m.Message, frozen=True, kw_only=True):
    """A message to publish on the loop."""

    message: Any


SENT = Topic("test/sent", Sent, origin="input")


class Loop(Node):
    """Stands in for the nodes of the loop."""

    name = "loop"
    emits: ClassVar[tuple[Topic[Any], ...]] = (t.ACTION, t.HALT, t.CUE, t.PROMPT, t.ATTEMPT_ENDED)

    @on(SENT)
    def sent(self, sent: Sent) -> None:
        topic = next(each for each in self.emits if each.type is type(sent.message))
        self.emit(topic, sent.message)


class Stage:
    """An output on a bus, and its reports. It is a fake one on a virtual clock unless others are
    given.
    """

    def __init__(
        self,
        output: Output | None = None,
        cues: tuple[str, ...] = (),
        clock: VirtualClock | None = None,
        **fake: Any,
    ) -> None:
        self.output: Any = output or FakeOutput(**fake)
        self.clock = clock or VirtualClock(SECOND)
        self.bus = Bus(self.clock)
        Loop().attach(self.bus)
        self.opened: list[m.OutputOpened] = []
        self.reports: list[m.OutputReport] = []
        self.stopped: list[m.OutputStopped] = []
        self.faults: list[Any] = []
        self.bus.subscribe(FAULT, self.faults.append)
        self.bus.subscribe(t.OUTPUT, self.opened.append)
        self.bus.subscribe(t.REPORT, self.reports.append)
        self.bus.subscribe(t.STOPPED, self.stopped.append)
        self.node = OutputNode(self.output, f"{self.output.name}:here", PLAIN_THEME, cues)
        self.node.attach(self.bus)
        self.clock.advance(0)

    def publish(self, message: m.Message) -> None:
        self.bus.publish(SENT, Sent(message=message))
        self.clock.advance(0)

    def act(self, action: str = "a1", **parts: str) -> "Stage":
        whole: Any = {"text": "", **parts}
        self.publish(
            m.Action(id=action, kind="feedback", decision="accepted", actor="agent", **whole)
        )
        return self

    def halt(self, action: str = "", reason: Any = "stopped", asked: int | None = None) -> None:
        asked = self.clock.now() if asked is None else asked
        self.publish(m.Halt(action=action, reason=reason, asked=asked))

    def report(
        self, part: Any, state: Any, action: str = "a1", at: Any = None, detail: Any = ""
    ) -> None:
        """Have the output report."""
        at = self.clock.now() if at is None else at
        self.send(Report(action, part, state, at, detail))

    def send(self, report: Any) -> None:
        """Have the output send a report, valid or not."""
        self.output._send_report(report)
        self.clock.advance(0)

    def wait(self, ns: int) -> None:
        self.clock.advance(ns)

    def states(self, action: str = "a1", part: ActionPart = "say") -> list[str]:
        return [each.state for each in self.reports if (each.action, each.part) == (action, part)]

    @property
    def asked(self) -> list[tuple[str, ...]]:
        """Requests of a fake output, except themes."""
        return [what for what in self.output.asked if what[0] != "apply_theme"]

    @property
    def stops(self) -> list[str]:
        """Details of the stops that were reported."""
        return [stopped.detail for stopped in self.stopped]


EVERY_PART = {
    **{"text": "Well done.", "spoken": "Well done!", "face": "happy"},
    **{"gesture": "wave", "gaze": "left", "tone": "success"},
}
LATE = "It did not stop in time."
UNCONFIRMED = "The robot did not confirm that it stopped."


# --- what is asked of it


def test_it_announces_its_address_and_its_parts_of_which_a_tone_only_if_it_plays_praise() -> None:
    (opened,) = Stage(can=frozenset({"say", "gesture"})).opened
    assert (opened.output, opened.address, opened.can) == ("fake", "fake:here", ("gesture", "say"))
    for cues, can in ((("go",), ()), (("success",), ("tone",)), ((), ("tone",))):
        assert Stage(cues=cues, can=frozenset({"tone"})).opened[0].can == can


def test_gaze_and_tone_are_the_first_parts_of_an_action() -> None:
    stage = Stage().act(**EVERY_PART)
    assert stage.asked == [
        ("show", "a1", "Well done.", "happy"),
        ("gaze", "a1", "left"),
        ("tone", "a1", "success"),
        ("gesture", "a1", "wave"),
        ("say", "a1", "Well done!"),
    ]
    assert [(report.part, report.state) for report in stage.reports] == [
        (part, "queued") for part in ("show", "gaze", "tone", "gesture", "say")
    ]


def test_an_output_is_asked_only_for_parts_that_it_can_do_and_an_action_has() -> None:
    for part in EVERYTHING:
        assert [what[0] for what in Stage(can=frozenset({part})).act(**EVERY_PART).asked] == [part]
    stage = Stage()
    edited = msgspec.structs.replace(PLAIN_THEME, name="edited")
    stage.bus.publish(t.THEME, m.ThemeApplied(theme=edited))
    assert stage.output.asked == [("apply_theme", "bench"), ("apply_theme", "edited")]
    stage.act(spoken="Reach out.").act("a2", face="happy")
    assert stage.asked == [("say", "a1", "Reach out."), ("show", "a2", "", "happy")]


# --- what it reports


def test_reports_are_passed_on_with_their_times() -> None:
    stage = Stage().act(spoken="Well done.")
    begun = SECOND + 7 * MS
    stage.wait(10 * MS)
    stage.report("say", "started", at=begun + 0.25)
    stage.wait(900 * MS)
    stage.report("say", "failed", at=begun + 800 * MS, detail="The cable is out.")
    assert [
        (report.output, report.state, report.at, report.detail) for report in stage.reports
    ] == [
        ("fake", "queued", SECOND, ""),
        ("fake", "started", begun, ""),
        ("fake", "failed", begun + 800 * MS, "The cable is out."),
    ]
    assert all(type(report.at) is int for report in stage.reports)


@pytest.mark.parametrize("part", sorted(EVERYTHING))
def test_a_part_that_raises_has_failed_and_the_others_continue(part: ActionPart) -> None:
    stage = Stage(breaks=(part,)).act(**EVERY_PART)
    assert {what[0] for what in stage.asked} == EVERYTHING
    failed = [(one.part, one.detail) for one in stage.reports if one.state == "failed"]
    assert failed == [(part, f"RuntimeError: no {part} today.")]
    assert stage.states(part=part) == ["queued", "failed"]


@pytest.mark.parametrize("part", LASTING)
def test_a_part_without_a_report_fails_after_a_time_and_is_stopped_even_if_that_fails(
    part: ActionPart,
) -> None:
    stage = Stage(can=frozenset({part, "show"}), breaks=("stop",))
    stage.act(**{**EVERY_PART, "spoken": "x" * 100})
    stage.wait(TIMEOUT + (100 * PER_CHARACTER if part == "say" else 0) - 1)
    assert stage.states(part=part) == ["queued"]
    stage.wait(1)
    assert stage.states(part=part) == ["queued", "failed"]
    assert stage.reports[-1].detail == "It did not report the outcome."
    assert stage.asked[-1] == ("stop", "a1")
    assert stage.states(part="show") == ["queued"], "a text stays until it is replaced"


@pytest.mark.parametrize("end", ["done", "aborted", "failed"])
def test_the_end_of_a_part_is_reported_once(end: str) -> None:
    stage = Stage().act(spoken="Well done.")
    for state in (end, "done", "aborted", "failed", "started"):
        stage.report("say", state)
    stage.wait(TIMEOUT + PER_CHARACTER * 100)
    assert stage.states() == ["queued", end]


class Unreadable(Exception):
    def __str__(self) -> str:
        raise ValueError("not even that")


@pytest.mark.parametrize(
    ("detail", "kept"),
    [
        (RuntimeError("jammed"), "jammed"),
        ("\ud800 is half a character", "? is half a character"),
        ("x" * 501, "x" * 500),
        (7, "7"),
        (Unreadable(), "a Unreadable that cannot be read"),
    ],
)
def test_a_detail_is_stored_as_encodable_text(detail: Any, kept: str) -> None:
    stage = Stage().act(gesture="wave")
    stage.report("gesture", "failed", detail=detail)
    assert stage.reports[-1].detail == kept
    assert stage.states(part="gesture") == ["queued", "failed"]


@pytest.mark.parametrize(
    ("part", "state", "at"),
    [
        *[("gesture", state, SECOND) for state in ("nonsense", ["done"])],
        *[(part, "done", SECOND) for part in ("dance", ["gesture"])],
        *[("gesture", "done", at) for at in (None, "soon", float("nan"), SECOND - 1, 2**70)],
        ("gesture", None, None),
    ],
)
def test_an_invalid_report_fails_its_part(part: Any, state: Any, at: Any) -> None:
    stage = Stage().act(gesture="wave").act("a2", gesture="wave")
    lacks_fields = SimpleNamespace(action="a1", part="gesture")
    stage.send(Report("a1", part, state, at) if state else lacks_fields)
    assert stage.states(part="gesture") == ["queued", "failed"]
    assert stage.reports[-1].detail == "Its report could not be understood."
    assert stage.states("a2", "gesture") == ["queued"]
    for each in stage.reports:
        assert msgspec.json.decode(msgspec.json.encode(each), type=m.OutputReport) == each


NO_PART: list[Any] = [None, "done", ("a1", "gesture", "done", SECOND, "")]
UNREQUESTED: list[Any] = [([], "say"), ("a1", "say"), ("a9", "gesture")]


@pytest.mark.parametrize("report", NO_PART + [Report(*of, "done", SECOND) for of in UNREQUESTED])
def test_a_report_without_a_part_or_on_an_unrequested_one_is_ignored(report: Any) -> None:
    stage = Stage().act(gesture="wave")
    stage.send(report)
    assert [one.state for one in stage.reports] == ["queued"]


def test_a_report_from_another_thread_arrives_on_the_thread_of_the_loop() -> None:
    stage = Stage().act(spoken="Well done.")
    on_thread: list[int] = []
    stage.bus.subscribe(t.REPORT, lambda _: on_thread.append(threading.get_ident()))
    report = Report("a1", "say", "done", stage.clock.now() + 5)
    thread = threading.Thread(target=stage.output._send_report, args=(report,))
    thread.start()
    thread.join()
    assert stage.states() == ["queued"], "not before the loop has its turn"
    stage.clock.advance(0)
    assert stage.states() == ["queued", "done"]
    assert (stage.reports[-1].at, on_thread) == (report.at, [threading.get_ident()])


def test_nothing_is_reported_after_a_release() -> None:
    stage = Stage().act(spoken="Well done.")
    stage.halt()
    stage.node.detach()
    stage.node.detach()
    stage.report("say", "done")
    stage.wait(3600 * SECOND)
    assert stage.states() == ["queued", "aborted"], "what it had not brought to its end"
    assert stage.stops == ["The session was left."]
    assert stage.asked.count(("close",)) == 1
    fake = FakeOutput()
    OutputNode(fake, "fake", PLAIN_THEME).detach()
    assert fake.asked == [], "it was not attached"


# --- one that is broken


class Cancelled(BaseException):
    """Like the cancellations of libraries, no Exception."""


@pytest.mark.parametrize("error", [RuntimeError, SystemExit, Cancelled])
def test_an_output_that_raises_or_ends_the_program_fails_with_the_reason_and_the_exit_goes_on(
    error: type[BaseException],
) -> None:
    unopened = Stage(breaks=("apply_theme",), error=error).act(**EVERY_PART)
    assert len(unopened.opened) == 1
    for part in EVERYTHING:
        assert unopened.states(part=part) == ["queued", "failed"]
    assert {report.detail for report in unopened.reports if report.state == "failed"} == {
        f"It could not be opened ({error.__name__}: no apply_theme today)."
    }
    assert unopened.asked == [], "nothing is asked of it"

    stage = Stage(breaks=("say", "stop", "close"), error=error).act(spoken="Well done!")
    stage.halt()
    stage.node.detach()
    stage.bus.drain()
    assert stage.states() == ["queued", "failed"]
    assert [(fault.topic, fault.error) for fault in stage.faults] == [
        ("close", f"{error.__name__}: no close today")
    ]


def test_ctrl_c_ends_a_simulation_while_an_output_is_asked() -> None:
    with pytest.raises(KeyboardInterrupt):
        Stage(breaks=("close",), error=KeyboardInterrupt).node.detach()


@pytest.mark.parametrize(
    ("part", "given"), [("say", "spoken"), ("show", "text"), ("gesture", "gesture")]
)
def test_a_part_without_a_method_has_failed_and_its_author_reads_why(
    part: ActionPart, given: str
) -> None:
    class Half(Output):
        name = "half"
        can = frozenset((part,))

    stage = Stage(Half()).act(**{given: "wave"})
    assert stage.states(part=part) == ["queued", "failed"]
    assert stage.reports[-1].detail == f"Half lists {part} in its can, but has no method {part}."


# --- in a simulated session


def test_an_output_knows_that_the_session_is_simulated_when_it_is_opened() -> None:
    told: list[bool] = []

    class Asking(FakeOutput):
        def apply_theme(self, theme: Theme) -> None:
            told.append(self.simulated)

    with host_clock() as live:
        for clock in (live, VirtualClock()):
            OutputNode(Asking(), "fake", PLAIN_THEME).attach(Bus(clock))
    assert told == [False, True]


def test_an_output_that_limits_its_time_by_the_clock_is_told_why_it_fails() -> None:
    class Bridge(FakeOutput):
        def gesture(self, action: str, name: str) -> None:
            self.clock.call_at(self.clock.now() + 30 * SECOND, lambda: None)

    stage = Stage(Bridge(), clock=PacedClock(SECOND)).act(gesture="wave")
    stage.wait(TIMEOUT)
    assert stage.states(part="gesture") == ["queued", "failed"]
    assert "In this simulation time jumped over its work" in stage.reports[-1].detail


def test_the_clock_waits_for_an_output_that_requests_no_timer_until_its_part_is_over() -> None:
    clock = PacedClock(SECOND)
    stage = Stage(clock=clock).act(gesture="wave")
    report = Report("a1", "gesture", "done", SECOND)
    threading.Timer(0.05, stage.output._send_report, [report]).start()
    while stage.states(part="gesture") == ["queued"]:
        assert clock.step()
    assert stage.states(part="gesture") == ["queued", "done"]
    assert clock.now() < SECOND + TIMEOUT
    stage.wait(3600 * SECOND)


# --- being still


def test_a_stop_is_reported_when_the_last_active_part_has_ended() -> None:
    stage = Stage().act(**EVERY_PART)
    asked_at = stage.clock.now() - 3 * MS
    stage.halt(asked=asked_at)
    assert stage.asked[-1] == ("stop", "")
    at = stage.clock.now()
    for part, after in {"say": 60, "tone": 40, "gaze": 10, "gesture": 20}.items():
        assert stage.stopped == []
        stage.report(part, "aborted", at=at + after * MS)
    (stopped,) = stage.stopped
    assert (stopped.output, stopped.asked, stopped.at) == ("fake", asked_at, at + 60 * MS)
    assert stopped.detail == ""
    assert stage.states(part="show") == ["queued"], "words may stay where they are"


def test_two_stops_in_a_row_are_reported_once_and_one_of_nothing_at_once() -> None:
    stage = Stage().act(spoken="Well done.")
    first = stage.clock.now()
    stage.halt()
    stage.wait(30 * MS)
    stage.halt()
    assert stage.asked.count(("stop", "")) == 2
    stage.report("say", "aborted")
    assert [(stopped.asked, stopped.at) for stopped in stage.stopped] == [(first, first + 30 * MS)]
    stage.halt(asked=stage.clock.now() - 2 * MS)
    assert stage.stopped[1].at - stage.stopped[1].asked == 2 * MS, "nothing was left to be stopped"


@pytest.mark.parametrize("reason", ["stopped", "interrupted", "left"])
def test_a_part_that_does_not_stop_has_failed_whatever_the_reason_of_the_stop(reason: str) -> None:
    stage = Stage().act(**EVERY_PART)
    stage.halt("" if reason == "stopped" else "a1", reason)
    stage.act("a2", gesture="wave")
    stage.wait(STOP_TIMEOUT - 1)
    assert {report.state for report in stage.reports} == {"queued"}
    assert stage.stopped == []
    stage.wait(1)
    for part in LASTING:
        assert stage.states(part=part) == ["queued", "failed"]
    assert stage.states(part="show") == ["queued"], "words may stay where they are"
    assert stage.states("a2", "gesture") == ["queued"], "a later gesture was not stopped"
    assert {report.detail for report in stage.reports if report.state == "failed"} == {LATE}
    assert [(stopped.at - stopped.asked, stopped.detail) for stopped in stage.stopped] == (
        [(STOP_TIMEOUT, LATE)] if reason == "stopped" else []
    )


@pytest.mark.parametrize("first", ["stopped in vain", "given up", "not confirmed"])
def test_a_second_stop_does_not_confirm_what_nothing_confirms(first: str) -> None:
    stage = Stage().act(gesture="wave")
    if first == "given up":
        stage.wait(TIMEOUT)
        why = "It did not report the outcome."
    else:
        stage.halt()
        if first == "not confirmed":
            stage.report("gesture", "aborted", detail=UNCONFIRMED)
        stage.wait(STOP_TIMEOUT)
        why = stage.stopped.pop().detail
        assert why
    stage.halt()
    assert stage.stops == [why]


@pytest.mark.parametrize(
    ("action", "state"),
    [("a1", "aborted"), ("a1", "done"), ("a2", "started"), ("a2", "done"), ("a2", "aborted")],
)
def test_a_stop_is_confirmed_once_the_output_reports_the_end_or_has_begun_the_next_part(
    action: str, state: str
) -> None:
    stage = Stage().act(gesture="wave", spoken="Well done.")
    stage.halt()
    stage.report("say", "aborted")
    stage.wait(STOP_TIMEOUT)
    stage.act("a2", gesture="wave")
    stage.report("gesture", "failed", detail="The arm is stuck.", action="a3")
    stage.report("gesture", state, action)
    stage.halt()
    stage.report("gesture", "aborted", "a2")
    assert stage.stops == [LATE, ""]


def test_a_stop_reports_each_failure_and_each_output_that_may_still_move_once() -> None:
    stage = Stage().act(**EVERY_PART)
    stage.halt()
    stage.wait(5 * MS)
    stage.report("tone", "done", detail="It was over in any case.")
    stage.report("gesture", "failed", detail="The arm could not be made limp.")
    stage.report("say", "aborted", detail=UNCONFIRMED)
    stage.report("gaze", "aborted", detail=UNCONFIRMED)
    assert stage.stops == [f"The arm could not be made limp. {UNCONFIRMED}"]
    assert stage.stopped[0].at == SECOND + 5 * MS


@pytest.mark.parametrize(
    ("error", "why"),
    [
        (OutputError, "no stop today"),
        (RuntimeError, "It could not be stopped (RuntimeError: no stop today)."),
    ],
)
def test_an_output_that_raises_on_stop_of_one_action_or_all_is_reported_as_possibly_moving(
    error: type[Exception], why: str
) -> None:
    stage = Stage(breaks=("stop",), error=error).act(spoken="Well done.").act("a2", gesture="wave")
    stage.halt("a1", "interrupted")
    assert stage.asked[-1] == ("stop", "a1")
    assert (stage.states(), stage.states("a2", "gesture")) == (["queued", "failed"], ["queued"])
    assert stage.stopped == []
    stage.halt()
    assert stage.states("a2", "gesture") == ["queued", "failed"]
    stage.wait(3600 * SECOND)
    assert stage.stops == [why]


# --- cues

_STIMULUS = {"stimulus": "f", "expected": "f", "text": "Press: f", "glyph": "f", "choices": 2}
_PROMPT = m.Prompt(attempt=1, trial=1, presentation=1, level=1, timeout=SECOND, **_STIMULUS)  # type: ignore[arg-type]
_SCORE: Any = {"metric": 500.0, "metric_unit": "ms", "accuracy": 1.0, "correct": 1, "trials": 1}
_ENDED = m.AttemptEnded(
    **{"attempt": 1, "practice": False, "level": 1, "outcome": "success", "feedback": "none"},
    **{"started": 0, "ended": SECOND, **_SCORE},
)
replace = msgspec.structs.replace


def play(stage: Stage) -> None:
    """Two trials, the first of which is shown twice; the attempt of two ends; praise; and it is
    scored once more.
    """
    for trial, presentation in ((1, 1), (1, 2), (2, 1)):
        stage.publish(replace(_PROMPT, trial=trial, presentation=presentation))
    for seat in "AB":
        stage.publish(replace(_ENDED, seat=seat))
    stage.act(text="Well done.", tone="success")
    stage.wait(SECOND)
    stage.publish(replace(_ENDED, metric=700.0))


@pytest.mark.parametrize(
    ("cues", "sounds"),
    [
        ("go end success", "go go go end success"),
        ("go", "go go go"),
        ("end", "end"),
        ("success", "success"),
        ("end success", "end success"),
        ("", "success"),
    ],
)
def test_each_cue_sounds_once_per_event_and_not_again_for_an_amended_attempt(
    cues: str, sounds: str
) -> None:
    stage = Stage(cues=tuple(cues.split()), can=frozenset({"tone"}))
    play(stage)
    assert [what[2] for what in stage.asked] == sounds.split()
    names = [what[1] for what in stage.asked]
    assert len(set(names)) == len(names), "each has a name of its own"


@pytest.mark.parametrize(
    ("can", "asked"),
    [
        ("gaze", [("gaze", "cue-1-2-1", "left")]),
        ("gesture", [("gesture", "cue-1-2-1", "point_left")]),
        ("say", []),
    ],
)
def test_gaze_before_a_prompt_is_immediate_on_every_capable_output(
    can: str, asked: list[tuple[str, ...]]
) -> None:
    stage = Stage(can=frozenset({can}))
    where: Any = {"side": "left", "gaze": "left", "gesture": "point_left"}
    stage.publish(m.CueGiven(attempt=1, trial=2, presentation=1, **where))
    assert stage.asked == asked
