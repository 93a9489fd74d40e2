"""The node of an output: each part is reported once as over, whatever the output does."""

import threading
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest

from sar_tui.loop.bus import FAULT, Bus, Topic
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.topics import (
    ACTION,
    ATTEMPT_ENDED,
    CUE,
    HALT,
    OUTPUT,
    PROMPT,
    REPORT,
    STOPPED,
    THEME,
)
from sar_tui.model import messages as m
from sar_tui.model.messages import ActionPart
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.node import PER_CHARACTER, STOP_TIMEOUT, TIMEOUT, OutputNode
from sar_tui.outputs.output import Output, OutputError, Report
from tests.outputs.contract import THEME as PLAIN_THEME
from tests.outputs.fake_outputs import EVERYTHING, FakeOutput, Speaker

LASTING: tuple[ActionPart, ...] = ("say", "gesture", "gaze", "tone")


class Sent(m.Message, frozen=True, kw_only=True):
    """A message to publish on the loop."""

    message: Any


SENT = Topic("test/sent", Sent, origin="input")
_TOPICS: dict[type, Topic[Any]] = {
    m.Action: ACTION,
    m.Halt: HALT,
    m.Prompt: PROMPT,
    m.CueGiven: CUE,
    m.AttemptEnded: ATTEMPT_ENDED,
}


class Loop(Node):
    """Stands in for the nodes of the loop."""

    name = "loop"
    emits = (ACTION, HALT, CUE, PROMPT, ATTEMPT_ENDED)

    @on(SENT)
    def sent(self, message: Sent) -> None:
        self.emit(_TOPICS[type(message.message)], message.message)


class Stage:
    """An output on a bus, and its reports."""

    def __init__(
        self, output: Output, cues: tuple[str, ...] = (), theme: Theme = PLAIN_THEME
    ) -> None:
        self.clock = VirtualClock(SECOND)
        self.bus = Bus(self.clock)
        Loop().attach(self.bus)
        self.opened: list[m.OutputOpened] = []
        self.reports: list[m.OutputReport] = []
        self.stopped: list[m.OutputStopped] = []
        self.faults: list[Any] = []
        self.bus.subscribe(FAULT, self.faults.append)
        self.bus.subscribe(OUTPUT, self.opened.append)
        self.bus.subscribe(REPORT, self.reports.append)
        self.bus.subscribe(STOPPED, self.stopped.append)
        self.node = OutputNode(output, f"{output.name}:here", theme, cues)
        self.node.attach(self.bus)
        self.clock.advance(0)

    def publish(self, message: m.Message) -> None:
        self.bus.publish(SENT, Sent(message=message))
        self.clock.advance(0)

    def act(self, action: str = "a1", **parts: str) -> None:
        whole = {"text": "", **parts}
        self.publish(
            m.Action(id=action, kind="feedback", decision="accepted", actor="agent", **whole)
        )  # type: ignore[arg-type]

    def halt(self, action: str = "", reason: Any = "stopped", asked: int | None = None) -> None:
        self.publish(
            m.Halt(action=action, reason=reason, asked=self.clock.now() if asked is None else asked)
        )

    def report(
        self,
        part: ActionPart,
        state: Any,
        action: str = "a1",
        at: int | None = None,
        detail: str = "",
    ) -> None:
        """Have the output report."""
        self.node.output._send_report(
            Report(action, part, state, self.clock.now() if at is None else at, detail)
        )
        self.clock.advance(0)

    def wait(self, ns: int) -> None:
        self.clock.advance(ns)

    def states(self, action: str = "a1", part: ActionPart = "say") -> list[str]:
        return [
            report.state
            for report in self.reports
            if (report.action, report.part) == (action, part)
        ]


def asked(stage: Stage) -> list[tuple[str, ...]]:
    """Return the requests of a fake output, except themes."""
    assert isinstance(stage.node.output, FakeOutput)
    return [what for what in stage.node.output.asked if what[0] != "apply_theme"]


EVERY_PART = {
    "text": "Well done.",
    "spoken": "Well done!",
    "face": "happy",
    "gesture": "wave",
    "gaze": "left",
    "tone": "success",
}


# --- what is asked of it


def test_it_announces_its_abilities_and_its_address() -> None:
    (opened,) = Stage(FakeOutput(can=frozenset({"say", "gesture"}))).opened
    assert (opened.output, opened.address, opened.can) == ("fake", "fake:here", ("gesture", "say"))


def test_gaze_and_tone_are_the_first_parts_of_an_action() -> None:
    stage = Stage(FakeOutput())
    stage.act(**EVERY_PART)
    assert asked(stage) == [
        ("show", "a1", "Well done.", "happy"),
        ("gaze", "a1", "left"),
        ("tone", "a1", "success"),
        ("gesture", "a1", "wave"),
        ("say", "a1", "Well done!"),
    ]
    assert [(report.part, report.state) for report in stage.reports] == [
        (part, "queued") for part in ("show", "gaze", "tone", "gesture", "say")
    ]


@pytest.mark.parametrize("part", sorted(EVERYTHING))
def test_an_output_is_asked_only_for_parts_it_can_do(part: ActionPart) -> None:
    stage = Stage(FakeOutput(can=frozenset({part})))
    stage.act(**EVERY_PART)
    assert [what[0] for what in asked(stage)] == [part]


def test_parts_that_an_action_lacks_are_not_requested() -> None:
    stage = Stage(FakeOutput())
    stage.act(spoken="Reach out.")
    stage.act("a2", face="happy")
    assert asked(stage) == [("say", "a1", "Reach out."), ("show", "a2", "", "happy")]


def test_an_edited_theme_is_applied() -> None:
    stage = Stage(FakeOutput())
    stage.bus.publish(
        THEME, m.ThemeApplied(theme=msgspec.structs.replace(PLAIN_THEME, name="edited"))
    )
    assert isinstance(stage.node.output, FakeOutput)
    assert stage.node.output.asked == [("apply_theme", "bench"), ("apply_theme", "edited")]


# --- what it reports


def test_reports_are_passed_on_with_their_times() -> None:
    stage = Stage(FakeOutput())
    stage.act(spoken="Well done.")
    begun = stage.clock.now() + 7 * MS
    stage.wait(10 * MS)
    stage.report("say", "started", at=begun)
    stage.wait(900 * MS)
    stage.report("say", "failed", at=begun + 800 * MS, detail="The cable is out.")
    assert [(report.state, report.at) for report in stage.reports] == [
        ("queued", SECOND),
        ("started", begun),
        ("failed", begun + 800 * MS),
    ]
    assert {report.output for report in stage.reports} == {"fake"}
    assert stage.reports[-1].detail == "The cable is out."


@pytest.mark.parametrize("part", sorted(EVERYTHING))
def test_a_part_that_raises_has_failed_and_the_others_continue(part: ActionPart) -> None:
    stage = Stage(FakeOutput(breaks=(part,)))
    stage.act(**EVERY_PART)
    assert {what[0] for what in asked(stage)} == EVERYTHING
    failed = [report for report in stage.reports if report.state == "failed"]
    assert [(report.part, report.detail) for report in failed] == [
        (part, f"RuntimeError: no {part} today.")
    ]
    assert stage.states(part=part) == ["queued", "failed"]


@pytest.mark.parametrize("part", LASTING)
def test_a_part_without_a_report_fails_after_a_time_and_is_stopped(part: ActionPart) -> None:
    stage = Stage(FakeOutput(can=frozenset({part})))
    stage.act(**{**EVERY_PART, "spoken": "x" * 100})
    limit = TIMEOUT + (100 * PER_CHARACTER if part == "say" else 0)
    stage.wait(limit - 1)
    assert stage.states(part=part) == ["queued"]
    stage.wait(1)
    assert stage.states(part=part) == ["queued", "failed"]
    assert stage.reports[-1].detail == "It did not report the outcome."
    assert asked(stage)[-1] == ("stop", "a1")


def test_text_stays_until_it_is_replaced() -> None:
    stage = Stage(FakeOutput())
    stage.act(text="Well done.", face="happy")
    stage.wait(3600 * SECOND)
    assert stage.states(part="show") == ["queued"]


@pytest.mark.parametrize("end", ["done", "aborted", "failed"])
def test_the_end_of_a_part_is_reported_once(end: str) -> None:
    stage = Stage(FakeOutput())
    stage.act(spoken="Well done.")
    for state in (end, "done", "aborted", "failed", "started"):
        stage.report("say", state)
    stage.wait(TIMEOUT + PER_CHARACTER * 100)
    assert stage.states() == ["queued", end]


def test_reports_on_unrequested_parts_are_ignored() -> None:
    stage = Stage(FakeOutput())
    stage.act(spoken="Well done.")
    stage.report("gesture", "done")
    stage.report("say", "done", action="a9")
    assert [report.state for report in stage.reports] == ["queued"]


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
    stage = Stage(FakeOutput())
    stage.act(gesture="wave")
    stage.report("gesture", "failed", detail=detail)
    assert stage.reports[-1].detail == kept
    assert stage.states(part="gesture") == ["queued", "failed"]


def test_an_exception_that_cannot_be_encoded_is_reported_readably() -> None:
    class Jammed(FakeOutput):
        def gesture(self, action: str, name: str) -> None:
            raise OSError("\udcff" * 1000)

    stage = Stage(Jammed())
    stage.act(gesture="wave")
    assert msgspec.json.encode(stage.reports[-1])
    assert stage.reports[-1].detail == f"OSError: {'?' * 491}."


def test_a_fractional_time_is_rounded() -> None:
    stage = Stage(FakeOutput())
    stage.act(gesture="wave")
    stage.report("gesture", "done", at=stage.clock.now() + 0.25)  # type: ignore[arg-type]
    assert stage.reports[-1].at == stage.clock.now()
    assert type(stage.reports[-1].at) is int


@pytest.mark.parametrize(
    "report",
    [
        Report("a1", "gesture", "nonsense", SECOND),  # type: ignore[arg-type]
        Report("a1", "gesture", ["done"], SECOND),  # type: ignore[arg-type]
        Report("a1", "dance", "done", SECOND),  # type: ignore[arg-type]
        Report("a1", ["gesture"], "done", SECOND),  # type: ignore[arg-type]
        Report("a1", "gesture", "done", None),  # type: ignore[arg-type]
        Report("a1", "gesture", "done", "soon"),  # type: ignore[arg-type]
        Report("a1", "gesture", "done", float("nan")),  # type: ignore[arg-type]
        Report("a1", "gesture", "done", SECOND - 1),
        Report("a1", "gesture", "done", 2**70),
        SimpleNamespace(action="a1", part="gesture"),
    ],
)
def test_an_invalid_report_fails_its_part(report: Any) -> None:
    stage = Stage(FakeOutput())
    stage.act(gesture="wave")
    stage.act("a2", gesture="wave")
    stage.node.output._send_report(report)
    stage.clock.advance(0)
    assert stage.states(part="gesture") == ["queued", "failed"]
    assert stage.reports[-1].detail == "Its report could not be understood."
    assert stage.states("a2", "gesture") == ["queued"]
    for each in stage.reports:
        assert msgspec.json.decode(msgspec.json.encode(each), type=m.OutputReport) == each


@pytest.mark.parametrize(
    "report", [None, "done", ("a1", "gesture", "done", SECOND, ""), Report([], "say", "done", 0)]
)  # type: ignore[arg-type]
def test_a_report_without_a_part_is_ignored(report: Any) -> None:
    stage = Stage(FakeOutput())
    stage.act(gesture="wave")
    stage.node.output._send_report(report)
    stage.clock.advance(0)
    assert stage.states(part="gesture") == ["queued"]


def test_a_report_from_another_thread_arrives_on_the_thread_of_the_loop() -> None:
    stage = Stage(FakeOutput())
    stage.act(spoken="Well done.")
    on_thread: list[int] = []
    stage.bus.subscribe(REPORT, lambda _: on_thread.append(threading.get_ident()))
    report = Report("a1", "say", "done", stage.clock.now() + 5)
    thread = threading.Thread(target=stage.node.output._send_report, args=(report,))
    thread.start()
    thread.join()
    assert stage.states() == ["queued"], "not before the loop has its turn"
    stage.clock.advance(0)
    assert stage.states() == ["queued", "done"]
    assert (stage.reports[-1].at, on_thread) == (report.at, [threading.get_ident()])


def test_nothing_is_reported_after_a_release() -> None:
    stage = Stage(FakeOutput())
    stage.act(spoken="Well done.")
    stage.halt()
    stage.node.detach()
    stage.node.detach()
    stage.report("say", "done")
    stage.wait(3600 * SECOND)
    assert stage.states() == ["queued", "aborted"], "what it had not brought to its end"
    assert [stopped.detail for stopped in stage.stopped] == ["The session was left."]
    assert asked(stage).count(("close",)) == 1


def test_an_unattached_output_can_be_released() -> None:
    fake = FakeOutput()
    OutputNode(fake, "fake", PLAIN_THEME).detach()
    assert fake.asked == []


# --- one that is broken


def test_an_output_that_cannot_be_opened_fails_every_part_with_the_reason() -> None:
    stage = Stage(FakeOutput(breaks=("apply_theme",)))
    stage.act(**EVERY_PART)
    assert len(stage.opened) == 1
    for part in EVERYTHING:
        assert stage.states(part=part) == ["queued", "failed"]
    assert {report.detail for report in stage.reports if report.state == "failed"} == {
        "It could not be opened (RuntimeError: no apply_theme today)."
    }
    assert asked(stage) == [], "nothing is asked of it"


def test_an_output_that_raises_on_close_does_not_block_the_exit() -> None:
    stage = Stage(FakeOutput(breaks=("close",)))
    stage.node.detach()
    stage.bus.drain()
    assert asked(stage) == [("close",)]
    assert [(fault.topic, fault.error) for fault in stage.faults] == [
        ("close", "RuntimeError: no close today")
    ]


class Cancelled(BaseException):
    """Like the cancellations of libraries, no Exception."""


@pytest.mark.parametrize("error", [SystemExit, Cancelled])
def test_an_output_that_ends_the_program_has_failed_like_any_other(
    error: type[BaseException],
) -> None:
    stage = Stage(FakeOutput(breaks=("say", "stop", "close"), error=error))
    stage.act(spoken="Well done!")
    stage.halt()
    stage.node.detach()
    stage.bus.drain()
    assert stage.states() == ["queued", "failed"]
    assert [fault.error for fault in stage.faults] == [f"{error.__name__}: no close today"]
    opened = Stage(FakeOutput(breaks=("apply_theme",), error=error))
    opened.act(spoken="Well done!")
    assert (
        opened.reports[-1].detail
        == f"It could not be opened ({error.__name__}: no apply_theme today)."
    )


def test_ctrl_c_ends_a_simulation_while_an_output_is_asked() -> None:
    with pytest.raises(KeyboardInterrupt):
        Stage(FakeOutput(breaks=("close",), error=KeyboardInterrupt)).node.detach()


@pytest.mark.parametrize(
    ("part", "given"), [("say", "spoken"), ("show", "text"), ("gesture", "gesture")]
)
def test_a_part_without_a_method_has_failed_and_its_author_reads_why(
    part: ActionPart, given: str
) -> None:
    class Half(Output):
        name = "half"
        can = frozenset((part,))

    stage = Stage(Half())
    stage.act(**{given: "wave"})
    assert stage.states(part=part) == ["queued", "failed"]
    assert stage.reports[-1].detail == f"Half lists {part} in its can, but has no method {part}."


def test_an_output_that_neither_reports_nor_stops_has_failed() -> None:
    stage = Stage(FakeOutput(breaks=("stop",)))
    stage.act(gesture="wave")
    stage.wait(TIMEOUT)
    assert stage.states(part="gesture") == ["queued", "failed"]


# --- being still


def test_a_stop_is_reported_when_the_last_active_part_has_ended() -> None:
    stage = Stage(FakeOutput())
    stage.act(**EVERY_PART)
    asked_at = stage.clock.now() - 3 * MS
    stage.halt(asked=asked_at)
    assert asked(stage)[-1] == ("stop", "")
    ends = {"say": 60 * MS, "tone": 40 * MS, "gaze": 10 * MS, "gesture": 20 * MS}
    at = stage.clock.now()
    for part, after in ends.items():
        assert stage.stopped == []
        stage.report(part, "aborted", at=at + after)  # type: ignore[arg-type]
    (stopped,) = stage.stopped
    assert (stopped.output, stopped.asked, stopped.at) == ("fake", asked_at, at + 60 * MS)
    assert stopped.detail == ""
    assert stage.states(part="show") == ["queued"], "words may stay where they are"


def test_a_stop_without_active_parts_is_reported_at_once() -> None:
    stage = Stage(FakeOutput())
    stage.halt(asked=stage.clock.now() - 2 * MS)
    (stopped,) = stage.stopped
    assert stopped.at - stopped.asked == 2 * MS


def test_two_stops_in_a_row_are_reported_once() -> None:
    stage = Stage(FakeOutput())
    stage.act(spoken="Well done.")
    first = stage.clock.now()
    stage.halt()
    stage.wait(30 * MS)
    stage.halt()
    assert asked(stage).count(("stop", "")) == 2
    stage.report("say", "aborted")
    assert [(stopped.asked, stopped.at) for stopped in stage.stopped] == [(first, first + 30 * MS)]


@pytest.mark.parametrize("reason", ["stopped", "interrupted", "left"])
def test_a_part_that_does_not_stop_has_failed_whatever_the_reason_of_the_stop(reason: str) -> None:
    stage = Stage(FakeOutput())
    stage.act(**EVERY_PART)
    stage.halt("" if reason == "stopped" else "a1", reason)
    stage.act("a2", gesture="wave")
    stage.wait(STOP_TIMEOUT - 1)
    assert {*(report.state for report in stage.reports)} == {"queued"}
    assert stage.stopped == []
    stage.wait(1)
    for part in LASTING:
        assert stage.states(part=part) == ["queued", "failed"]
    assert stage.states(part="show") == ["queued"], "words may stay where they are"
    assert stage.states("a2", "gesture") == ["queued"], "a later gesture was not stopped"
    assert {report.detail for report in stage.reports if report.state == "failed"} == {
        "It did not stop in time."
    }
    assert [(stopped.at - stopped.asked, stopped.detail) for stopped in stage.stopped] == (
        [(STOP_TIMEOUT, "It did not stop in time.")] if reason == "stopped" else []
    )


def test_an_output_that_did_not_stop_can_be_stopped_again() -> None:
    stage = Stage(FakeOutput())
    stage.act(gesture="wave")
    stage.halt()
    stage.wait(STOP_TIMEOUT)
    stage.act("a2", gesture="wave")
    stage.halt()
    stage.report("gesture", "aborted", "a2")
    stage.wait(STOP_TIMEOUT)
    assert [stopped.detail for stopped in stage.stopped] == ["It did not stop in time.", ""]


@pytest.mark.parametrize("first", ["stopped in vain", "given up", "not confirmed"])
def test_a_second_stop_does_not_confirm_what_nothing_confirms(first: str) -> None:
    stage = Stage(FakeOutput())
    stage.act(gesture="wave")
    if first == "given up":
        stage.wait(TIMEOUT)
        why = "It did not report the outcome."
    else:
        stage.halt()
        if first == "not confirmed":
            stage.report("gesture", "aborted", detail="The robot did not confirm that it stopped.")
        stage.wait(STOP_TIMEOUT)
        why = stage.stopped.pop().detail
        assert why
    stage.halt()
    assert [stopped.detail for stopped in stage.stopped] == [why]


@pytest.mark.parametrize(
    ("action", "state"), [("a1", "aborted"), ("a1", "done"), ("a2", "started"), ("a2", "done")]
)
def test_a_stop_is_confirmed_once_the_output_reports_the_end_or_has_begun_the_next_part(
    action: str, state: str
) -> None:
    stage = Stage(FakeOutput())
    stage.act(gesture="wave", spoken="Well done.")
    stage.halt()
    stage.report("say", "aborted")
    stage.wait(STOP_TIMEOUT)
    stage.act("a2", gesture="wave")
    stage.report("gesture", "failed", detail="The arm is stuck.", action="a3")
    stage.report("gesture", state, action)
    stage.halt()
    stage.report("gesture", "aborted", "a2")
    assert [stopped.detail for stopped in stage.stopped] == ["It did not stop in time.", ""]


def test_a_stop_reports_each_failure_and_each_output_that_may_still_move_once() -> None:
    stage = Stage(FakeOutput())
    stage.act(**EVERY_PART)
    stage.halt()
    at = stage.clock.now() + 5 * MS
    stage.wait(5 * MS)
    stage.report("tone", "done", detail="It was over in any case.")
    stage.report("gesture", "failed", detail="The arm could not be made limp.")
    stage.report("say", "aborted", detail="The robot did not confirm that it stopped.")
    stage.report("gaze", "aborted", detail="The robot did not confirm that it stopped.")
    (stopped,) = stage.stopped
    assert stopped.at == at
    assert (
        stopped.detail
        == "The arm could not be made limp. The robot did not confirm that it stopped."
    )


def test_a_stop_does_not_wait_for_later_parts() -> None:
    stage = Stage(FakeOutput())
    stage.act("a1", gesture="wave")
    stage.halt()
    stage.act("a2", gesture="wave")
    stage.report("gesture", "aborted", "a1")
    assert len(stage.stopped) == 1


def test_an_output_may_report_why_it_may_still_be_moving() -> None:
    class Away(FakeOutput):
        def stop(self, action: str = "") -> None:
            raise OutputError("The robot could not be asked to stop.")

    stage = Stage(Away())
    stage.halt()
    assert [stopped.detail for stopped in stage.stopped] == [
        "The robot could not be asked to stop."
    ]


def test_an_output_that_raises_on_stop_is_reported_as_possibly_moving() -> None:
    stage = Stage(FakeOutput(breaks=("stop",)))
    stage.act(gesture="wave", spoken="Well done.")
    stage.halt()
    (stopped,) = stage.stopped
    assert stopped.detail == "It could not be stopped (RuntimeError: no stop today)."
    for part in ("gesture", "say"):
        assert stage.states(part=part) == ["queued", "failed"]  # type: ignore[arg-type]
    stage.wait(3600 * SECOND)
    assert len(stage.stopped) == 1


def test_one_action_is_stopped_without_the_others() -> None:
    stage = Stage(FakeOutput(breaks=("stop",)))
    stage.act("a1", spoken="Welcome.")
    stage.act("a2", gesture="wave")
    stage.halt("a1", "interrupted")
    assert asked(stage)[-1] == ("stop", "a1")
    assert (stage.states("a1"), stage.states("a2", "gesture")) == (["queued", "failed"], ["queued"])
    assert stage.stopped == []


def test_an_output_can_be_used_after_a_stop() -> None:
    speaker = Speaker(takes_ms=800)
    stage = Stage(speaker)
    stage.act("a1", spoken="Welcome.")
    stage.act("a2", spoken="Reach out.")
    stage.wait(100 * MS)
    stage.halt()
    stage.act("a3", spoken="Well done.")
    stage.wait(SECOND)
    assert [stage.states(action) for action in ("a1", "a2", "a3")] == [
        ["queued", "started", "aborted"],
        ["queued", "aborted"],
        ["queued", "started", "done"],
    ]
    assert [stopped.at - stopped.asked for stopped in stage.stopped] == [0]


# --- cues


def prompt(trial: int = 1, presentation: int = 1) -> m.Prompt:
    return m.Prompt(
        attempt=1,
        trial=trial,
        presentation=presentation,
        level=1,
        stimulus="f",
        expected="f",
        text="Press: f",
        glyph="f",
        choices=2,
        timeout=SECOND,
    )


def attempt_ended(ended: int, attempt: int = 1, metric: float = 500.0) -> m.AttemptEnded:
    return m.AttemptEnded(
        attempt=attempt,
        practice=False,
        level=1,
        metric=metric,
        metric_unit="ms",
        accuracy=1.0,
        correct=1,
        trials=1,
        outcome="success",
        feedback="none",
        started=0,
        ended=ended,
    )


def play(stage: Stage) -> None:
    """Two trials, the first of which is shown twice; praise; and the attempt is scored once
    more.
    """
    stage.publish(prompt(1, 1))
    stage.publish(prompt(1, 2))
    stage.publish(prompt(2, 1))
    ended = stage.clock.now()
    stage.publish(attempt_ended(ended))
    stage.act(text="Well done.", tone="success")
    stage.wait(SECOND)
    stage.publish(attempt_ended(ended, metric=700.0))


@pytest.mark.parametrize(
    ("cues", "sounds"),
    [
        (("go", "end", "success"), ["go", "go", "go", "end", "success"]),
        (("go",), ["go", "go", "go"]),
        (("end",), ["end"]),
        (("success",), ["success"]),
        (("end", "success"), ["end", "success"]),
    ],
)
def test_each_cue_sounds_once_per_event_and_not_again_for_an_amended_attempt(
    cues: tuple[str, ...], sounds: list[str]
) -> None:
    stage = Stage(FakeOutput(can=frozenset({"tone"})), cues)
    play(stage)
    assert [what[2] for what in asked(stage)] == sounds
    names = [what[1] for what in asked(stage)]
    assert len(set(names)) == len(names), "each has a name of its own"


def test_the_attempt_of_two_ends_once() -> None:
    stage = Stage(FakeOutput(can=frozenset({"tone"})), ("end",))
    for seat in "AB":
        stage.publish(msgspec.structs.replace(attempt_ended(stage.clock.now()), seat=seat))
    assert [what[2] for what in asked(stage)] == ["end"]


@pytest.mark.parametrize(
    ("can", "done"), [(("gaze",), ["gaze"]), (("gesture",), ["gesture"]), (("say",), [])]
)
def test_gaze_before_a_prompt_is_immediate_on_every_capable_output(
    can: tuple[str, ...], done: list[str]
) -> None:
    stage = Stage(FakeOutput(can=frozenset(can)))
    stage.publish(
        m.CueGiven(
            attempt=1, trial=2, presentation=1, side="left", gaze="left", gesture="point_left"
        )
    )
    assert [what[0] for what in asked(stage)] == done
    assert [(what[1], what[2]) for what in asked(stage)] == [
        ("cue-1-2-1", {"gaze": "left", "gesture": "point_left"}[part]) for part in done
    ]


def test_an_output_without_cues_plays_only_tones_of_actions() -> None:
    stage = Stage(FakeOutput())
    play(stage)
    assert [what[0] for what in asked(stage)] == ["show", "tone"]


def test_praise_is_announced_as_a_tone_only_by_outputs_that_play_it() -> None:
    def can(*cues: str) -> tuple[str, ...]:
        return Stage(FakeOutput(can=frozenset({"tone"})), cues).opened[0].can

    assert (can("go"), can("success"), can()) == ((), ("tone",), ("tone",))


# --- one after the other


def test_successive_utterances_are_reported_in_order() -> None:
    stage = Stage(Speaker())
    stage.act("a1", spoken="A thing.")
    stage.act("a2", spoken="Another.")
    stage.wait(3 * SECOND)
    assert stage.states("a1") == stage.states("a2") == ["queued", "started", "done"]
    at = {(report.action, report.state): report.at for report in stage.reports}
    assert at["a1", "done"] == at["a2", "started"] == at["a1", "started"] + SECOND
