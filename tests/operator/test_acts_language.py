"""Acts, events, answers and the palette are in the language of the panel; what the agent says is in
that of the session.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from sar_tui import operator
from sar_tui.checks.task_translations import texts_in
from sar_tui.link import admission
from sar_tui.link.peer import Connection
from sar_tui.loop import topics as t
from sar_tui.loop.answers import OpenActs, answer_to
from sar_tui.loop.bus import Topic
from sar_tui.model import messages as m
from sar_tui.model.language import Language, read_words
from sar_tui.model.step import Step
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.operator.app import panel_texts
from sar_tui.operator.commands import Commands
from sar_tui.operator.event_text import event_line, session_text, stopper
from sar_tui.operator.keymap import KeymapFile
from sar_tui.operator.palette import Palette, PhraseBook, pages
from sar_tui.operator.phrases import addressee, phrase_problem
from sar_tui.operator.session_state import UNCONFIRMED, SessionState
from sar_tui.plugins import Catalogue
from sar_tui.rules.difficulty import (
    Bounds,
    Difficulty,
    OneUpOneDownSettings,
    PercentileSettings,
    ScoredAttempt,
    SequenceSettings,
    TargetSettings,
    percentile_goal,
    step_by_outcome,
    step_in_list,
    step_to_target,
)
from sar_tui.store.interface_language import choose_interface_language
from tests.operator import panel_driver as b
from tests.operator.test_acts import ACTS, NOW, OTHERS, PROPOSAL, Panel, command, decision, stopped
from tests.operator.test_event_text import BEFORE, EVENTS, ME
from tests.translations import OTHERS as LANGUAGES
from tests.translations import code_in
from tests.untranslated import english_in

WORDS = Path(operator.__file__).parent / "words.es.toml"
INHERITED = {"Marked: {mark}", "Paused", "goal reached", "you"}
TEXTS = INHERITED.union(read_words(WORDS), *map(texts_in, code_in("operator")))
"""All texts of the panel, and the answers of the session that it translates."""
ANSWERS = (
    "No prompt is shown.",
    "It did not arrive.",
    "It was over already.",
    "It was stopped before its end.",
    "There is nothing to take back any more.",
)
GESTURE = b.approval("p1", kind="gesture", text="", spoken="", gesture="nod")
LEVEL = b.approval("p1", level=5)
BEN = b.presence("baton", "operator.ben", ben="operator")
CONSENT = Step(name="consent", text="?", kind="choice", labels=("y", "n"), required="y")
READ = m.AskedStep(number=1, step=Step(name="read", text="?"))
PAUSED = b.waiting("resume", "paused")


@pytest.fixture(params=LANGUAGES)
def tr(request: pytest.FixtureRequest) -> Language:
    return panel_texts(request.param)


def english(shown: Iterable[str], tr: Language) -> list[tuple[str, str]]:
    """Return the texts of the panel that are shown in English."""
    return english_in(shown, {text: tr.texts[text] for text in TEXTS & tr.texts.keys()})


def lines(panel: Panel) -> list[str]:
    log, state = panel.commands.log.lines, panel.commands.state
    stops = [stop.line(NOW) for stop in state.stops]
    return [line.text_with_count for line in (*log, *state.log, *stops)]


# --- acts


MORE_ACTS: list[Callable[[Commands], Any]] = [
    lambda c: c.decide(PROPOSAL, "veto", NOW),
    *(
        lambda c, valence=valence: c.change_valence(PROPOSAL, valence, NOW)  # type: ignore[misc]
        for valence in ("positive", "neutral", "negative")
    ),
    lambda c: c.edit(LEVEL, "3", NOW),
    lambda c: c.say("+++", "A", NOW),
    lambda c: c.prompt_command("repeat", NOW),
    lambda c: c.command("undo", NOW),
    lambda c: c.command("end", NOW),
    lambda c: c.command("stop", NOW),
]


@pytest.mark.parametrize("act", [*(act for act, *_ in ACTS), *MORE_ACTS])
def test_an_act_is_told_in_the_panels_language_until_and_after_it_is_done(
    act: Callable[[Commands], Any], tr: Language
) -> None:
    shown: list[str] = []
    for outcome, why in [("done", ""), ("done", "removed"), ("late", ""), ("refused", "")] + [
        ("late", why) for why in ANSWERS
    ]:
        panel = Panel(tr=tr)
        assert act(panel.commands)
        shown += [*lines(panel), panel.commands.log.deciding("p1")]
        panel.answer(outcome, why)
        shown += lines(panel)
    assert english(shown, tr) == []


@pytest.mark.parametrize("waiting", [b.waiting("response"), PAUSED])
@pytest.mark.parametrize("state", ["lost", "ended"])
def test_remarks_that_wait_or_are_not_confirmed_are_in_the_panels_language(
    waiting: m.Waiting, state: Any, tr: Language
) -> None:
    panel = Panel(tr=tr)
    panel.commands.receive(b.welcome(participants={"A": "P01", "B": "P02"}))
    panel.receive(t.WAITING, waiting)
    panel.commands.say("+++", "B", NOW)
    panel.commands.pause(NOW)
    panel.commands.say("+++", "A", NOW)
    shown = lines(panel)
    panel.answer("refused", ANSWERS[0], 0)
    panel.answer("done")
    panel.commands.receive(Connection(state))
    assert english([*shown, *lines(panel)], tr) == []


def skip_at(waiting: m.Waiting) -> Callable[[Panel], Any]:
    def skip(panel: Panel) -> None:
        panel.receive(t.WAITING, waiting)
        panel.commands.prompt_command("skip", NOW)

    return skip


def mark_again(panel: Panel) -> None:
    panel.receive(t.TRIAL, b.trial(4, "f", 400))
    marked = m.TrialMarked(attempt=3, trial=4, mark="missed", correct=False)
    panel.receive(t.MARKED, marked)
    state = panel.commands.state
    marks = next(page for page in pages(state, PhraseBook({}), "A") if page.kind == "marks")
    for _ in range(2):
        panel.commands.pick(marks.items[1], NOW)


def say_unknown(panel: Panel) -> None:
    panel.commands.say("{result}", "A", NOW)
    state = panel.commands.state
    own = PhraseBook.of(state, KeymapFile(phrases=("{result}",)))
    panel.commands.pick(pages(state, own, "A")[0].items[0], NOW)


def release_level(panel: Panel) -> None:
    panel.receive(t.ARBITER_STATE, b.arbiter_state(modes={**b.MODES, "difficulty": "manual"}))
    panel.commands.hold(NOW)


def without_level(panel: Panel) -> None:
    panel.commands.state = replace(panel.commands.state, level=None)
    panel.commands.level(1, NOW)


def too_soon(panel: Panel) -> None:
    panel.commands.shown = ("p1", NOW)
    panel.commands.decide(PROPOSAL, "accept", NOW)


def without_control(panel: Panel) -> None:
    panel.commands.control_key = "b"
    panel.receive(t.PRESENCE, BEN)
    panel.commands.note("+++", NOW)


def without_connection(panel: Panel) -> None:
    panel.commands.receive(Connection("lost"))
    panel.commands.note("+++", NOW)


@pytest.mark.parametrize(
    "act",
    [
        *(
            skip_at(waiting)
            for waiting in (
                b.waiting("enter", "attempt"),
                b.waiting("rest", "rest"),
                b.waiting("step", "step", step=READ),
                b.waiting("step", "step", step=replace(READ, step=replace(CONSENT, before=True))),
            )
        ),
        mark_again,
        say_unknown,
        release_level,
        without_level,
        too_soon,
        without_control,
        without_connection,
        lambda panel: panel.commands.edit(LEVEL, "x", NOW),
        lambda panel: panel.commands.edit(LEVEL, "0", NOW),
        lambda panel: panel.commands.edit(LEVEL, "11", NOW),
        lambda panel: panel.commands.edit(GESTURE, "+++", NOW),
    ],
)
def test_an_act_that_depends_on_the_session_is_told_in_the_panels_language(
    act: Callable[[Panel], Any], calm: Theme, tr: Language
) -> None:
    panel = Panel(tr=tr)
    panel.receive(t.THEME, m.ThemeApplied(theme=calm))
    act(panel)
    shown = lines(panel)
    assert shown
    if panel.peer.sent:
        panel.answer()
        shown += lines(panel)
    assert english(shown, tr) == []


def test_an_observer_is_refused_in_the_panels_language(tr: Language) -> None:
    panel = Panel("observer", tr)
    panel.commands.note("+++", NOW)
    assert english(lines(panel), tr) == []


MORE_OTHERS: list[tuple[Topic[Any], Any]] = [
    (t.DECISION, decision("veto")),
    (t.DECISION, decision("edit", gesture="nod")),
    (t.MODE, m.ModeChanged(kind="gesture", mode="autonomous")),
    (t.COMMAND, command("repeat")),
    (t.COMMAND, command("end")),
    (t.COMMAND, command("undo")),
    (t.NOTE_ADDED, m.NoteAdded(text="+++")),
    (t.NOTE_ADDED, m.NoteAdded(label="+++")),
]


@pytest.mark.parametrize("actor", [b.ANNA, "operator.ben", "therapist", "participant"])
@pytest.mark.parametrize(
    ("topic", "act"), [*((topic, act) for topic, act, _ in OTHERS), *MORE_OTHERS]
)
def test_what_others_do_is_told_in_the_panels_language(
    topic: Topic[Any], act: Any, actor: str, tr: Language
) -> None:
    panel = Panel("observer", tr)
    act = replace(act, id="1", actor=actor, at=NOW)
    panel.receive(topic, act)
    shown = lines(panel)
    panel.receive(t.ANSWERED, answer_to(act, NOW))
    shown += lines(panel)
    assert english(shown, tr) == []
    assert not any("participant" in line for line in shown), "they are named by their code"


def test_numbers_in_what_is_typed_stay_as_they_are(tr: Language) -> None:
    panel = Panel(tr=tr)
    panel.commands.say("1.5 %, 20%", "A", NOW)
    panel.commands.note("0.5", NOW)
    said, noted = lines(panel)
    assert "1.5 %, 20%" in said
    assert "0.5" in noted


# --- events


def test_a_count_of_events_is_in_the_panels_language(tr: Language) -> None:
    panel = Panel(tr=tr)
    for _ in range(3):
        panel.receive(t.STORAGE, m.StorageChanged(working=True))
    (shown,) = lines(panel)
    assert shown.startswith("3")
    assert english([shown], tr) == []


def change(state: Any, actor: str = b.ANNA, **more: Any) -> m.OperatorChanged:
    return m.OperatorChanged(actor=actor, state=state, operated=True, **more)


def refused(actor: str, what: str, count: int = 1) -> m.PeerRequestRefused:
    return m.PeerRequestRefused(actor=actor, what=what, why="It did not arrive.", count=count)


MORE_EVENTS: list[tuple[Topic[Any], m.Message]] = [
    *(
        (topic, m.SensorChanged(state=state, at=0))  # type: ignore[arg-type]
        for topic in (t.SENSOR, t.TRUNK_SENSOR)
        for state in ("attached", "detached", "stalled", "flowing", "ended")
    ),
    *(
        (t.DROPPED, m.Dropped(id=id, reason=reason))  # type: ignore[arg-type]
        for id in ("p1", "l1", "?")
        for reason in ("late", "stopped", "amended", "expired", "no operator")
    ),
    *(
        (t.PRESENCE, change(state, actor, role=role, detail=why))  # type: ignore[arg-type]
        for state in ("baton", "joined", "left", "unproven", "lost")
        for actor, role in ((b.ANNA, "operator"), ("observer.cara", "observer"))
        for why in ("", "The connection broke.")
    ),
    *(
        (t.COMMAND, command("pause", reason, actor=actor))
        for reason in ("", "tired", "pain", "finished")
        for actor in ("participant", "therapist", "operator.ben")
    ),
    (t.COMMAND, command("resume", actor="operator.ben")),
    (t.COMMAND, command("skip", "attempt")),
    *(
        (t.REFUSED, refused(actor, what, count))
        for actor in (b.ANNA, "operator.ben")
        for what in (t.MODE.name, t.REMARK.name, t.PROPOSAL_SEEN.name, "an act", "a connection")
        for count in (1, 3)
    ),
    (t.LEVEL, m.LevelChanged(previous=3, level=4, reason="mark")),
    (t.LEVEL, m.LevelChanged(previous=3, level=4, reason="failure")),
    *(
        (t.LEVEL_DECIDED, m.LevelDecided(id="l1", at=0, level=5, **parts))  # type: ignore[arg-type]
        for parts in (
            {"decision": "rejected", "ground": "operator", "actor": b.ANNA},
            {"decision": "accepted", "ground": "no operator", "actor": "agent"},
        )
    ),
    (t.SETTING, m.SettingChanged(name="feedback_every", value=3)),
    (t.SETTING, m.SettingChanged(name="+++", value=0.5)),
    (t.STORAGE, m.StorageChanged(working=True)),
    (t.PRESENCE, change("joined", "operator.ben")),
    (t.PRESENCE, change("joined", role="observer")),
]


@pytest.mark.parametrize(
    ("topic", "message"), [*((topic, message) for topic, message, _ in EVENTS), *MORE_EVENTS]
)
def test_events_are_told_in_the_panels_language(
    topic: Topic[Any], message: m.Message, tr: Language
) -> None:
    line = event_line(b.frame(topic, message), ME, BEFORE, tr)
    assert english([line.text] if line else [], tr) == []


def reasons() -> Iterator[str]:
    """Yield the reasons that the included policies give for another level or goal."""
    bounds = Bounds(1, 9)
    for outcome in ("success", "failure"):
        attempt = ScoredAttempt(1, outcome, reached=4, prompts=9)  # type: ignore[arg-type]
        for needed in (1, 2):
            steps = OneUpOneDownSettings(consecutive_successes=needed, consecutive_failures=needed)
            state = Difficulty(5)
            for _ in range(needed):
                state = step_by_outcome(state, attempt, steps, bounds)
            yield state.why
        for share in ("prompts", "attempts"):
            target = TargetSettings(target_share=62.5, target_of=share)  # type: ignore[arg-type]
            yield step_to_target(Difficulty(5), attempt, target, bounds).why
    listed = SequenceSettings(level_sequence=(1, 2))
    yield step_in_list(Difficulty(1), ScoredAttempt(1, "success"), listed, bounds).why
    for results in ([1.0], [1.0, 2.0, 3.0]):
        goal = percentile_goal(results, "lower", PercentileSettings())
        yield goal.why if goal else ""


def failures() -> Iterator[str]:
    """Yield sentences of the session and of the link with values in them."""
    answers: list[m.ActAnswered] = []
    acts = OpenActs(answers.append)
    acts.add_request("a1", m.Remark(id="1"), NOW)
    acts.begin("a1", [("speech", "say"), ("robot", "say")])
    for output in ("speech", "robot"):
        acts.report(m.OutputReport(action="a1", output=output, part="say", state="failed", at=NOW))
    yield answers[0].why
    yield from (admission._TOO_FAST, admission._TOO_LONG)


@pytest.mark.parametrize("why", [*reasons(), *failures()])
def test_sentences_of_the_session_with_values_are_in_the_panels_language(
    why: str, tr: Language
) -> None:
    assert why
    own = session_text(why, tr)
    assert own != why
    assert "62.5" not in own
    numbers = re.findall(r"\d+", why)
    assert sorted(re.findall(r"\d+", own)) == sorted(numbers)


def test_numbers_of_events_are_written_as_in_the_panels_language(tr: Language) -> None:
    goal = m.GoalChanged(previous=0.5, goal=0.25, unit="s", reason="percentile", why="")
    line = event_line(b.frame(t.GOAL, goal), ME, BEFORE, tr)
    assert line
    assert "0,5 → 0,25 s" in line.text
    where = m.MarkersChanged(destination="tcp:10.0.0.1", state="working", at=0)
    line = event_line(b.frame(t.MARKERS, where), ME, BEFORE, tr)
    assert line
    assert "10.0.0.1" in line.text


@pytest.mark.parametrize("actor", ["participant", "therapist", b.ANNA])
def test_a_stop_is_told_in_the_panels_language(actor: str, tr: Language) -> None:
    panel = Panel(tr=tr)

    def shown() -> Iterator[str]:
        for stop in panel.commands.state.stops:
            for now in (NOW, NOW + 2 * UNCONFIRMED):
                yield stop.line(now).text
                yield stop.outcome(now, tells_time=False)[0]

    texts: list[str] = []
    for outputs in ((), ("robot",), ("speech",)):
        for output in outputs:
            opened = m.OutputOpened(output=output, address=output, can=("say",))
            panel.receive(t.OUTPUT, opened)
        panel.receive(t.COMMAND, command("stop", actor=actor, at=NOW))
        texts += shown()
    panel.receive(t.STOPPED, stopped("robot", NOW + 20 * MS))
    texts += shown()
    panel.receive(t.STOPPED, stopped("speech", NOW, "It did not stop in time."))
    texts += shown()
    assert english(texts, tr) == []


@pytest.mark.parametrize("me", [None, b.welcome(participants={"A": "P01", "B": "P02"})])
def test_a_participant_who_is_not_known_is_named_in_the_panels_language(
    me: Any, tr: Language
) -> None:
    assert english([stopper("participant", me, tr)], tr) == []


def test_a_voice_that_fails_without_a_reason_is_told_in_the_panels_language(tr: Language) -> None:
    report = m.OutputReport(action="a1", output="speech", part="say", state="failed", at=0)
    panel = Panel(tr=tr)
    panel.receive(t.REPORT, report)
    assert english([panel.commands.state.voice], tr) == []


# --- the palette


def all_of(page: Any) -> Iterator[str]:
    yield from (page.title, page.empty)
    for item in page.items:
        yield from (item.text, item.why, *item.wording)


def test_the_palette_is_in_the_panels_language_and_its_phrases_in_that_of_the_session(
    calm: Theme, tr: Language
) -> None:
    state = SessionState(tr).receive(Connection("connected"))
    file = KeymapFile(phrases=("{result}",))
    shown = [text for page in pages(state, PhraseBook({}), "A") for text in all_of(page)]
    state = state.receive(b.welcome(participants={"A": "P01", "B": "P02"}))
    frames = [
        b.frame(t.THEME, m.ThemeApplied(theme=calm)),
        b.frame(
            t.ARBITER_STATE,
            b.arbiter_state(queued=(b.action("a9", text="+++"),), current=b.action("a8")),
        ),
    ]
    state = state.receive(frames)
    shown.append(f"+{addressee(state, 'B')}")
    found = pages(state, PhraseBook.of(state, file), "B")
    shown += [page.title for page in found]
    shown += [text for page in found if page.kind in ("modes", "queue") for text in all_of(page)]
    shown += all_of(found[0])
    assert english(shown, tr) == []
    said = [item.text for page in found if page.kind == "phrases" for item in page.items]
    assert set(calm.phrases["encouragement"]) <= set(said)


def test_an_open_page_stays_open_in_any_language(calm: Theme, tr: Language) -> None:
    state = SessionState(tr).receive(Connection("connected")).receive(b.welcome())
    state = state.receive([b.frame(t.THEME, m.ThemeApplied(theme=calm))])
    palette = Palette(KeymapFile())
    palette.use_theme(state)
    palette.turn(state, 1)
    assert palette.find(state)[1] == 1


@pytest.mark.parametrize("phrase", ["", "{", "{+}"])
def test_a_broken_phrase_is_explained_in_the_panels_language(phrase: str, tr: Language) -> None:
    assert english([phrase_problem(phrase, tr)], tr) == []


# --- keys


@pytest.mark.slow
@pytest.mark.parametrize("code", LANGUAGES)
async def test_the_texts_of_keys_are_in_the_panels_language(
    catalogue: Catalogue, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str
) -> None:
    choose_interface_language(tmp_path, code)
    async with b.open_panel(catalogue, tmp_path) as driver:
        panel, shown = driver.panel, []
        probe = driver.app.terminal_probe
        monkeypatch.setattr(probe, "take_longest_silence", lambda: 5 * SECOND)
        for people in ({"A": "P01"}, {"A": "P01", "B": "P02"}):
            await driver.join(participants=people)
            for key in ("t", "n", "e"):
                await driver.press(key)
                shown.append(panel.strip._label)
                await driver.press("escape")
        for text in (PROPOSAL, LEVEL):
            await driver.propose(text)
            await driver.press("e")
            shown.append(panel.strip._label)
            await driver.publish(t.ARBITER_STATE, b.arbiter_state())
            await driver.press("enter")
            shown.append(panel.strip._label)
            await driver.press("escape")
        for key in ("s", "r", "ctrl+z", "f2", "space", "end", "end"):
            await driver.press(key)
        await driver.receive(Connection("lost"))
        await driver.press("t")
        shown += [line.text for line in panel.commands.log.lines]
        assert any("5 s" in text for text in shown)
        assert len(shown) > 12
        assert english(shown, panel.tr) == []
