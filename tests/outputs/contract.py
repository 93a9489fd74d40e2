"""Checks that every output must pass, each with an open one: `CHECKS`, each ``check(rig)``.

To put an output under the contract, write a context manager that yields a `Rig` of it, and add it
to ``RIGS`` in ``test_contract.py``.
"""

import asyncio
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext

import msgspec

from sar_tui.loop.clock import Clock, LiveClock, VirtualClock
from sar_tui.model.gesture import Gesture, Keyframe
from sar_tui.model.messages import ActionPart
from sar_tui.model.theme import FACES, Colors, Note, Theme
from sar_tui.model.units import MS
from sar_tui.outputs.node import valid_report
from sar_tui.outputs.output import Output, Report

WAIT_S = 60.0
"""Time to wait for another thread or process before a check fails."""
OVER = ("done", "aborted", "failed")
_LIVES = ([], ["started"], ["aborted"], ["failed"], *(["started", end] for end in OVER))
"""Valid sequences of reports of a part: without ``started`` there is no ``done``."""

_LA = Note(880, 300)
THEME = Theme(
    name="bench",
    title="Bench",
    summary="What the contract is checked with.",
    dark=True,
    minimum_contrast=4.5,
    colors=Colors(*["#000000"] * 2, *["#ffffff"] * 6),
    faces=dict.fromkeys(FACES, "( o o )\n(  ~  )\n(_____)"),
    phrases={},
    gestures={
        "wave": Gesture((Keyframe(at_ms=300, right_arm=0.6), Keyframe(at_ms=600))),
        "nod": Gesture((Keyframe(at_ms=200, nod=0.4), Keyframe(at_ms=400))),
    },
    tones={"go": (_LA,), "success": (Note(660, 150), _LA), "end": (Note(520, 300),)},
)
"""The first theme of an output."""
_BACKWARDS = Gesture((Keyframe(at_ms=250, right_arm=-0.5), Keyframe(at_ms=500)))
OTHER_THEME = msgspec.structs.replace(
    THEME, name="other", gestures=dict.fromkeys(("wave", "nod"), _BACKWARDS)
)

_WHAT: dict[ActionPart, str] = {
    "say": "You were forty milliseconds faster than before.",
    "show": "Well done.",
    "gesture": "wave",
    "gaze": "left",
    "tone": "go",
}
TEXTS = (
    "Well done.",
    "",
    " ",
    "أحسنت! لقد كنت أسرع من المرة السابقة.",
    "做得很好，比上次快了四十毫秒。",
    "👍🏽 👩‍👩‍👧 ✅",
    "\x00\x07\x1b[2J\x7f\x85",
    "One.\nTwo.\r\nThree.\tFour.",
    "<speak>&amp; \"quotes\" 'and' \\ [[inpUt]] | $(true) `true`",
    "e\u0301\u202eabc\u202c\ufeff\u200b",
    "\ud800",
    "a" * 2000,
)
"""Texts that an output may have to say or show."""


class Rig:
    """An output that is open, what it reported, and time.

    Args:
        output: not yet open.
        clock: its clock. A virtual one advances only while the rig waits for something.
        lasting: the parts that take time by themselves, rather than being over at once or when
            others follow.
    """

    def __init__(self, output: Output, clock: Clock, lasting: Sequence[ActionPart]) -> None:
        self.output = output
        self.clock = clock
        self.lasting = tuple(lasting)
        self.reports: list[Report] = []
        self.asked: list[tuple[str, ActionPart]] = []
        self._lock = threading.Lock()
        output.open(THEME, clock, self._collect)

    def _collect(self, report: Report) -> None:
        with self._lock:
            self.reports.append(report)

    def ask(self, part: ActionPart, action: str, what: str | None = None) -> None:
        """Request a part; any text or name will do if ``what`` is None."""
        self.asked.append((action, part))
        what = _WHAT[part] if what is None else what
        getattr(self.output, part)(action, what, *(["happy"] if part == "show" else []))

    def ask_much(self, part: ActionPart, action: str) -> None:
        """Request a part that takes long enough to be stopped."""
        self.ask(part, action, "One word after the other. " * 20 if part == "say" else None)

    def states(self, action: str, part: ActionPart) -> list[str]:
        """Return the reported states of a part, in order."""
        return [r.state for r in list(self.reports) if (r.action, r.part) == (action, part)]

    def ended(self, action: str, part: ActionPart) -> bool:
        """Return True if a part is over, as often as it was requested."""
        over = sum(state in OVER for state in self.states(action, part))
        return over >= self.asked.count((action, part))

    def detail(self, action: str, part: ActionPart) -> str:
        """Return the detail with which a part ended."""
        of = (r for r in self.reports if (r.action, r.part) == (action, part))
        return next(r.detail for r in of if r.state in OVER)

    def wait(self, until: Callable[[], bool]) -> None:
        """Let time pass until a condition holds; fail if it does not."""
        if isinstance(self.clock, VirtualClock):
            while not until():
                assert self.clock.step(), f"nothing is due any more; reported: {self.reports}"
        else:
            deadline = time.monotonic() + WAIT_S
            while not until():
                assert time.monotonic() < deadline, f"waited in vain; reported: {self.reports}"
                time.sleep(0.002)

    def wait_for(self, part: ActionPart, *actions: str) -> None:
        """Let time pass until these are over."""
        self.wait(lambda: all(self.ended(action, part) for action in actions))

    def wait_for_start(self, part: ActionPart, action: str) -> None:
        """Let time pass until a part has started."""
        self.wait(lambda: "started" in self.states(action, part))
        assert not self.ended(action, part)

    def check_reports(self) -> None:
        """Check that each part was requested, started before it ended, and ended once; times
        increase.
        """
        assert {(report.action, report.part) for report in self.reports} <= set(self.asked)
        for action, part in self.asked:
            assert self.states(action, part) in _LIVES, (action, part)
        for part in self.output.can:
            times = [report.at for report in self.reports if report.part == part]
            assert times == sorted(times)
        for report in self.reports:
            kept = valid_report(report, 0, self.clock.now())
            assert kept, "it can be understood"
            assert kept[:4] == report[:4]
            assert isinstance(report.detail, str)


@contextmanager
def host_clock() -> Iterator[LiveClock]:
    """Provide a clock as in a live session."""
    loop = asyncio.new_event_loop()
    try:
        yield LiveClock(loop)
    finally:
        loop.close()


@contextmanager
def rig_of(output: Output, *lasting: ActionPart, live: bool = False) -> Iterator[Rig]:
    """Provide a rig of an output, on a virtual clock unless it is to be live."""
    with host_clock() if live else nullcontext(VirtualClock()) as clock:
        rig = Rig(output, clock, lasting)
        try:
            yield rig
        finally:
            output.close()


def words_are_done_when_others_take_their_place(rig: Rig) -> None:
    if "show" in rig.output.can:
        rig.ask("show", "first")
        rig.ask("show", "second")
        rig.wait_for("show", "first")
        assert rig.states("first", "show")[-1] == "done"
        assert not rig.ended("second", "show")
    rig.check_reports()


def a_look_ends(rig: Rig) -> None:
    if "gaze" in rig.output.can:
        for where in ("left", "ahead"):
            rig.ask("gaze", where, where)
        rig.wait_for("gaze", "left", "ahead")
    rig.check_reports()


def a_method_returns_while_the_part_is_still_to_be_done(rig: Rig) -> None:
    for part in rig.lasting:
        rig.ask_much(part, "slow")
        assert not rig.ended("slow", part)
        rig.output.stop()
        rig.wait_for(part, "slow")


def parts_of_one_kind_follow_each_other_in_order(rig: Rig) -> None:
    for part in rig.lasting:
        actions = ["a", "b", "c", "d"]
        for action in actions:
            rig.ask(part, action, "Yes." if part == "say" else None)
        rig.wait_for(part, *actions)
        logged = [(report.action, report.state) for report in rig.reports if report.part == part]
        assert logged == [(action, state) for action in actions for state in ("started", "done")]
    rig.check_reports()


def the_same_action_may_be_done_again(rig: Rig) -> None:
    for part in rig.lasting:
        for times in (1, 2):
            rig.ask(part, "again")
            rig.wait_for(part, "again")
            assert rig.states("again", part) == ["started", "done"] * times


def stop_is_harmless_when_nothing_is_under_way(rig: Rig) -> None:
    rig.output.stop()
    rig.output.stop("nobody")
    assert rig.reports == []
    parts_of_one_kind_follow_each_other_in_order(rig)


def stop_aborts_what_is_under_way_and_what_waits_and_then_it_works_again(rig: Rig) -> None:
    for part in rig.lasting:
        rig.ask_much(part, "under way")
        rig.ask(part, "waiting")
        rig.wait_for_start(part, "under way")
        rig.output.stop()
        rig.output.stop()
        rig.ask(part, "afterwards")
        rig.wait_for(part, "under way", "waiting", "afterwards")
        assert rig.states("under way", part) == ["started", "aborted"]
        assert rig.states("waiting", part) == ["aborted"]
        assert rig.states("afterwards", part) == ["started", "done"]
    rig.check_reports()


def stop_before_it_began_aborts_it(rig: Rig) -> None:
    for part in rig.lasting:
        rig.ask_much(part, "hasty")
        rig.output.stop("hasty")
        rig.wait_for(part, "hasty")
        assert rig.states("hasty", part)[-1] == "aborted"
    rig.check_reports()


def stop_of_one_that_is_under_way_leaves_the_one_that_waits(rig: Rig) -> None:
    for part in rig.lasting:
        rig.ask_much(part, "under way")
        rig.ask(part, "waiting")
        rig.wait_for_start(part, "under way")
        rig.output.stop("under way")
        rig.wait_for(part, "under way", "waiting")
        assert rig.states("under way", part) == ["started", "aborted"]
        assert rig.states("waiting", part) == ["started", "done"]
    rig.check_reports()


def stop_of_one_that_waits_leaves_the_one_that_is_under_way(rig: Rig) -> None:
    for part in rig.lasting:
        rig.ask(part, "under way")
        rig.ask(part, "waiting")
        rig.output.stop("waiting")
        rig.wait_for(part, "under way", "waiting")
        assert rig.states("under way", part) == ["started", "done"]
        assert rig.states("waiting", part) == ["aborted"]
    rig.check_reports()


def stop_of_another_action_stops_nothing(rig: Rig) -> None:
    for part in rig.lasting:
        rig.ask(part, "mine")
        rig.output.stop("somebody else's")
        rig.wait_for(part, "mine")
        assert rig.states("mine", part) == ["started", "done"]


def another_theme_may_be_applied_while_a_part_is_under_way(rig: Rig) -> None:
    for part in rig.lasting:
        rig.ask(part, "before")
        rig.wait_for_start(part, "before")
        rig.output.apply_theme(OTHER_THEME)
        rig.ask(part, "after")
        rig.wait_for(part, "before", "after")
        assert rig.states("after", part) == ["started", "done"]
        rig.output.apply_theme(THEME)
    rig.check_reports()


def a_name_that_the_theme_lacks_fails_with_a_sentence(rig: Rig) -> None:
    for part in rig.lasting:
        if part in ("gesture", "tone"):
            rig.ask(part, "unheard of", "somersault")
            rig.ask(part, "known")
            rig.wait_for(part, "unheard of", "known")
            assert rig.states("unheard of", part) == ["failed"]
            assert "somersault" in rig.detail("unheard of", part)
            assert rig.detail("unheard of", part).endswith(".")
            assert rig.states("known", part) == ["started", "done"]


def any_text_is_borne(rig: Rig) -> None:
    for part in ("say", "show", "gesture", "tone"):
        if part in rig.output.can:
            for index, text in enumerate(TEXTS):
                rig.ask(part, f"text {index}", text)
                if index % 2:
                    rig.output.stop()
            if part != "show":
                rig.output.stop()
                rig.wait_for(part, *(f"text {index}" for index in range(len(TEXTS))))
    rig.check_reports()


def close_is_harmless_twice_and_nothing_is_reported_afterwards(rig: Rig) -> None:
    for part in rig.lasting:
        rig.ask_much(part, "under way")
        rig.ask(part, "waiting")
    for part in rig.lasting:
        rig.wait_for_start(part, "under way")
    rig.output.close()
    logged = list(rig.reports)
    rig.output.stop()
    rig.output.close()
    if isinstance(rig.clock, VirtualClock):
        rig.clock.advance(60_000 * MS)
    assert rig.reports == logged
    rig.check_reports()


CHECKS: tuple[Callable[[Rig], None], ...] = (
    words_are_done_when_others_take_their_place,
    a_look_ends,
    a_method_returns_while_the_part_is_still_to_be_done,
    parts_of_one_kind_follow_each_other_in_order,
    the_same_action_may_be_done_again,
    stop_is_harmless_when_nothing_is_under_way,
    stop_aborts_what_is_under_way_and_what_waits_and_then_it_works_again,
    stop_before_it_began_aborts_it,
    stop_of_one_that_is_under_way_leaves_the_one_that_waits,
    stop_of_one_that_waits_leaves_the_one_that_is_under_way,
    stop_of_another_action_stops_nothing,
    another_theme_may_be_applied_while_a_part_is_under_way,
    a_name_that_the_theme_lacks_fails_with_a_sentence,
    any_text_is_borne,
    close_is_harmless_twice_and_nothing_is_reported_afterwards,
)
