"""A session for screen readers and braille: lines that are appended one at a time, and nothing else.

It has the loop, the texts, the keys and the record of any other session.
"""

import asyncio
import contextlib
import functools
import os
import signal
import sys
import threading
from collections.abc import Callable, Coroutine, Iterator, Sequence
from datetime import date
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from msgspec.structs import replace
from textual.events import Key, Paste
from textual.message import Message

from sar_tui.app import wellbeing
from sar_tui.app.command_line import command_line
from sar_tui.app.forms import FormInterview, access_settings, begin_form, form_language
from sar_tui.app.interview import Interview
from sar_tui.app.leaving import lines_about
from sar_tui.app.letters import AWAITED_SECONDS, Letters
from sar_tui.app.live import LAST_WRITE_SECONDS, LiveSession, link_of
from sar_tui.app.plain_terminal import PlainTerminal
from sar_tui.app.prompt_needs import PROMPTS, prompts_of, refusal
from sar_tui.app.screen_keys import ScreenKeys
from sar_tui.app.screens.pause import act_of, pause_choices, pause_words
from sar_tui.app.screens.summary import ending as end_of_session
from sar_tui.app.screens.summary import facts
from sar_tui.app.screens.waiting_text import (
    WATCHED,
    decline_text,
    help_text,
    key_name,
    step_text,
    waiting_text,
)
from sar_tui.app.wellbeing_interview import ALONE, TELL_OF_PAIN, WellbeingInterview
from sar_tui.link.errors import LinkError
from sar_tui.loop import topics
from sar_tui.loop.clock import LiveClock, host_now
from sar_tui.loop.task import Task
from sar_tui.model.gesture import Gesture
from sar_tui.model.language import Language, in_language
from sar_tui.model.messages import (
    Action,
    AttemptEnded,
    AttemptStarted,
    Feedback,
    Prompt,
    Recall,
    SessionCommand,
    SessionEnded,
    Shown,
    StepEnded,
    TrialFeedback,
    TrialFeedbackShown,
    TrialMarked,
    Waiting,
)
from sar_tui.model.results_for_people import meeting_text
from sar_tui.model.spoken_text import sentences
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue, PluginError
from sar_tui.records.kind import Kind
from sar_tui.rules.declaration import ParameterError
from sar_tui.runs.plan import EnoughToday, Plan, set_up
from sar_tui.runs.plugin_watchdog import PluginWatchdog
from sar_tui.store import records, sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.forms import Occasion
from sar_tui.store.training_days import utc
from sar_tui.tui.base_app import punctual_loop
from sar_tui.tui.exit_codes import FAILED, INTERRUPTED, after_signal
from sar_tui.tui.gc_control import GcControl
from sar_tui.tui.language import app_language, planned_language, session_language
from sar_tui.tui.terminal_input import PasteDropped, UnreadableInput
from sar_tui.widgets.task_view import TaskView, view_of

if TYPE_CHECKING:
    from sar_tui.app.at_home import FromClinic
    from sar_tui.letterbox.exchange import Exchanged
    from sar_tui.link.broker_process import BrokerProcess

Result = TypeVar("Result")
Item = Message | int | Callable[[], Any]
"""Input of the terminal, an exit code with which to end, or something to be done in between."""
_HANG_UP = after_signal(getattr(signal, "SIGHUP", 1))
"""Exit code once the terminal is gone, to which nothing can be said any more."""


class Ended(Exception):
    """The program is to end, with an exit code."""

    def __init__(self, code: int) -> None:
        super().__init__(str(code))
        self.code = code


def untold(task: Task, seed: int) -> str:
    """Return a sentence that says why a task cannot be done in plain lines; empty if it can."""
    why = ""
    if len(task.seats) > 1:
        why = "two people see different things"
    elif task.parameters.switch != "none":
        why = "a switch takes what is marked on a screen"
    elif task.sensor_seats(task.parameters):
        why = "it shows a movement"
    elif type(view_of(type(task))(task)).prompt_lines is not TaskView.prompt_lines:
        why = "its prompts are drawings"
    else:
        shown: Any
        for count, shown in enumerate(prompts_of(task, seed)):
            if count == PROMPTS:
                break
            if getattr(shown, "halves", ()) or shown.picture or getattr(shown, "cue", None):
                why = "its prompts have sides or pictures"
                break
    return (
        f"The task {task.name} cannot be told in one line, as {why}: leave out --plain."
        if why
        else ""
    )


class PlainApp:
    """Runs sessions in plain lines, one after the other.

    Args:
        folder: the data folder.
        catalogue: the installed tasks and themes.
        patient: the participant who trains alone; empty if somebody else begins the session.
        link: lets operators join the session; None if only its settings decide that.
        markers: addresses to which each session's markers are sent.

    Attributes:
        screen_keys: judges which keys are meant for what was told last.
        what_next: what the participant does after the session; empty if its programme says that.
    """

    def __init__(
        self,
        folder: Path,
        catalogue: Catalogue,
        patient: str = "",
        link: "BrokerProcess | None" = None,
        markers: Sequence[str] = (),
    ) -> None:
        self.folder, self.catalogue, self.patient = folder, catalogue, patient
        self._link, self._markers = link, markers
        self.database = connect(folder)
        self.letters = Letters(folder, self._letters_came)
        self.screen_keys = ScreenKeys(lambda: host_now() / SECOND)
        self.what_next = ""
        self._items: asyncio.Queue[Item] = asyncio.Queue()
        self._terminal: PlainTerminal
        self._live: LiveSession | None = None
        self._failure = ""
        self._troubles: list[str] = []
        self._must_rest = False
        self._place: object = None
        self._told: list[str] = []

    # --- lines

    def say(self, *texts: str) -> None:
        """Append each sentence as a line."""
        for sentence in sentences(*texts):
            self._terminal.write(sentence)

    def tell(self, place: object, found: Sequence[str]) -> None:
        """Append sentences as lines: of the same place, only what was not there before."""
        if place != self._place:
            self._place, self._told = place, []
        self.say(*(each for each in found if each not in self._told))
        self._told = list(found)

    def write(self, text: str) -> int:
        """Append a text as one line, and return when it was written (ns)."""
        return self._terminal.write(text)

    def echo(self, before: str, now: str) -> None:
        """Append what was typed after ``before``. After a deletion, or another line in between, all
        that was typed begins a new line.
        """
        if now.startswith(before) and self._terminal.is_line_open:
            self._terminal.extend(now[len(before) :])
        else:
            self._terminal.end_line()
            self._terminal.extend(now)

    def notify(self, message: str, /, *, severity: Any = "", timeout: float | None = None) -> None:
        """Tell the therapist, in patient mode once it ends."""
        if not self.patient:
            self.say(message)
        elif message not in self._troubles:
            self._troubles.append(message)

    # --- keys

    async def key(self, asking: object) -> Key:
        """Return the next key that is meant for what asks. Raises Ended if it ends the program."""
        while True:
            item = await self._items.get()
            if isinstance(item, int):
                raise Ended(item)
            if not isinstance(item, Message):
                await item()
            elif not isinstance(item, Key):
                self._record(item)
            elif self._is_meant_for(asking, item) and not await self._handles(item):
                return item

    def _is_meant_for(self, asking: object, key: Key) -> bool:
        return self.screen_keys.pass_on(key, key.time, asking, is_therapist=False)

    def later(self, do: Callable[[], Any]) -> None:
        """Have something done before the next key."""
        self._items.put_nowait(do)

    @property
    def _open_session(self) -> LiveSession | None:
        """The session that is under way."""
        return self._live if self._live and not self._live.is_closed else None

    async def _handles(self, key: Key) -> bool:
        """Handle a key that means the same everywhere. Return True if it was one."""
        if key.key in ("ctrl+c", "ctrl+q"):
            self._leave(key.key)
        elif key.key == "f2":
            if live := self._open_session:
                at = round(key.time * SECOND)
                live.operate(SessionCommand(command="stop", at=at))
        elif key.key == "f12" and self.patient:
            await self._ask_passphrase()
        else:
            return False
        return True

    def _record(self, item: Message) -> None:
        """Record in the session what came from the terminal and is no key."""
        if not (live := self._open_session):
            return
        match item:
            case Paste():
                live.keyboard.pasted(len(item.text), item.time)
            case PasteDropped():
                live.keyboard.pasted(item.length, item.time)
            case UnreadableInput():
                live.keyboard.dropped(item.what, item.time)

    def _leave(self, key: str) -> None:
        """End the program; in patient mode, pause the session."""
        if not self.patient:
            raise Ended(INTERRUPTED if key == "ctrl+c" else 0)
        self._pause()

    def _pause(self) -> None:
        if (live := self._open_session) and not live.session.ended:
            live.operate(SessionCommand(command="pause"))

    async def _ask_passphrase(self) -> None:
        """End patient mode if the passphrase is right. Escape, or Enter without one, goes back."""
        from sar_tui.store.passphrase import Passphrase

        self._pause()
        tr, passphrase = app_language("en"), Passphrase(self.folder)
        self.say(tr("For the therapist"), tr("Please enter the passphrase."))
        if typed := await self._typed_in_secret():
            try:
                if passphrase.check(typed, "patient mode"):
                    raise Ended(0)
                self.say(tr("That is not the passphrase."))
            except StoreError as error:
                self.say(in_language(error, tr))
            if (wait := passphrase.wait_s) > 0:
                text = tr("Please wait {seconds} s, then try again.", seconds=ceil(wait))
                self.say(text)
        self.say(*self._told)

    async def _typed_in_secret(self) -> str:
        """Return what is typed up to Enter, without an echo; empty after Escape."""
        typed = ""
        while True:
            item = await self._items.get()
            if isinstance(item, int):
                raise Ended(item)
            if not isinstance(item, Message):
                await item()
            elif isinstance(item, Key):
                match item.key:
                    case "enter":
                        return typed
                    case "escape":
                        return ""
                    case "backspace":
                        typed = typed[:-1]
                    case _ if item.is_printable:
                        typed += item.character or ""

    # --- questions

    async def ask(self, interview: Interview[Result]) -> Result:
        """Ask the questions of an interview; returns its result."""
        place, typed = None, ""
        while not interview.is_over:
            self.tell((interview, interview.place), interview.page().sentences)
            entered = interview.entry.typed
            if place != interview.place:
                place, typed = interview.place, ""
                self.screen_keys.appeared()
            elif interview.step and interview.step.kind == "text" and entered != typed:
                self.echo(typed, entered)
                typed = entered
            key = await self.key(interview)
            interview.press(key.key, key.character)
        return interview.result

    async def fill_form(self, kind: Kind, of: Occasion, language: str = "") -> None:
        """Have a participant fill in a form. What is answered is stored, also if it is left."""
        answers, parameters, _ = begin_form(self.database, kind, of, language)
        self.screen_keys.set_bounce(parameters.bounce_ms)
        tr = form_language(parameters.language)
        await self.ask(FormInterview(kind, answers, tr, self.notify))

    # --- a session

    async def session(self, what: "Plan | str") -> None:
        """Run a new session (a plan), or an interrupted one (its id).

        Raises:
            StoreError, PluginError, ParameterError, Failed, LinkError: it cannot begin.
        """
        self._failure, asked_since = "", ""
        if isinstance(what, Plan):
            what = replace(what, id=what.id or sessions.new_id())
            self.screen_keys.set_bounce(what.parameters.bounce_ms)
            if what.parameters.ask_wellbeing:
                asked_since = utc()
                if not (may_begin := await self._may_begin(what)):
                    self._must_rest = may_begin is False
                    return
        self.letters.wait(AWAITED_SECONDS)
        with contextlib.ExitStack() as stack:
            opened = link_of(what, self.database, self.folder, self.notify)
            link = self._link or stack.enter_context(opened)
            live, stage = self._open(what, link)
            if asked_since:
                with contextlib.suppress(StoreError):  # they stay with the participant
                    codes = list(live.codes.values())
                    records.attach(self.database, live.run.id, codes, asked_since)
            await self._play(live, stage)
        self.letters.begin()
        if live.asks_after and not self._failure:
            await self.ask(wellbeing.ask_after(self, live))
        self._must_rest = live.session.ended and wellbeing.had_better_rest(self, live)
        self._warn(list(live.codes.values()))

    async def _may_begin(self, plan: Plan) -> bool | None:
        """Ask before a session. Return False if pain speaks against it, None if the questions are
        left.
        """
        theme = self.catalogue.theme(plan.theme, plan.parameters.language)
        task, codes = set_up(plan.task, plan.parameters), list(plan.participants)
        may_begin = await self.ask(wellbeing.ask_before(self, task, theme, codes))
        if self.patient:
            self._warn(codes)
        return may_begin

    def _warn(self, codes: Sequence[str]) -> None:
        """Tell the therapist of pain and tiredness."""
        for text in wellbeing.warnings(self, codes, Language()):
            self.notify(text)

    def _open(
        self, what: "Plan | str", link: "BrokerProcess | None"
    ) -> "tuple[LiveSession, PlainStage]":
        def refuse(task: Task, seed: int) -> str:
            return untold(task, seed) or refusal(task, seed, no_color=True)

        clock = LiveClock(asyncio.get_running_loop())
        live = LiveSession(
            self.folder,
            self.catalogue,
            clock,
            link=link,
            markers=self._markers,
            refusal=refuse,
            is_plain=True,
        )
        stage = PlainStage(self, live)
        live.open(stage, what)
        self._live = live
        self.screen_keys.set_bounce(live.session.task.parameters.bounce_ms)
        return live, stage

    async def _play(self, live: LiveSession, stage: "PlainStage") -> None:
        """Run a session to its end, and close it, whatever happens."""

        def broken(why: str) -> None:
            self._failure = why

        def step_ended(ended: StepEnded) -> None:
            if advice := wellbeing.advise(self, live, ended):
                live.operate(SessionCommand(command="pause", reason="pain", seat=ended.seat))
                self.later(functools.partial(stage.ask_in_pause, advice))

        live.session.bus.subscribe(topics.STEP_ENDED, step_ended)
        assert isinstance(live.clock, LiveClock)
        running = asyncio.get_running_loop().create_task(live.clock.run())
        running.add_done_callback(self._stopped)
        writing = threading.Thread(target=live.store, name="storage", daemon=True)
        writing.start()
        live.begin_loop(broken)
        live.session.bus.subscribe(topics.PRESENCE, lambda _: stage.visitors_changed())
        try:
            while not stage.is_left:
                stage.pressed(await self.key(stage))
        finally:
            stage.gc.end_attempt()
            running.cancel()
            live.release()
            live.write_rest()
            live.finish()
            writing.join(LAST_WRITE_SECONDS)

    def _stopped(self, running: "asyncio.Task[None]") -> None:
        """End the program if the session's loop has failed."""
        if not running.cancelled() and (error := running.exception()):
            self._failure = f"The session failed ({error}). What was done so far is kept."
            self._items.put_nowait(FAILED)

    # --- a participant who trains alone

    async def _train_alone(self) -> None:
        """Offer the exercises of the day one after the other, until the passphrase ends it."""
        from sar_tui.runs.patient_plan import (
            PLAN_ERRORS,
            day_plan,
            exercises,
            plan_exercise,
            unfinished,
        )

        clinic, skipped = self._from_clinic(), set[str]()
        self.letters.begin()
        self.letters.wait(AWAITED_SECONDS)  # what comes now is told first
        while True:
            if clinic:
                await self._read_letters(clinic)
            names = exercises(self.database, self.folder, self.catalogue, self.patient)
            today = date.today()
            day = day_plan(self.database, self.folder, self.patient, names, today)
            to_do = [one for one in day if not (one.is_done or one.name in skipped)]
            if self._must_rest:
                self._must_rest = False
                await self._rest("You can rest now.", TELL_OF_PAIN, ALONE)
                continue
            if not to_do:
                await self._rest("That was everything. Well done!", "You can rest now.")
                continue
            name = to_do[0].name
            skipped.add(name)  # whatever becomes of it, the next one is another
            try:
                plan = plan_exercise(
                    self.database,
                    self.catalogue,
                    self.patient,
                    name,
                    is_known=to_do[0].is_known,
                )
                if await self._offer(plan, names.index(name) + 1, len(names), len(to_do) > 1):
                    found = unfinished(self.database, self.folder, self.patient, name)
                    await self.session(found or plan)
                    for text in self._lines_about_session():
                        self.notify(text)
            except EnoughToday:
                continue
            except (*PLAN_ERRORS, LinkError) as error:
                self.notify(str(error))
                self.say(self._tr("This does not work now. Please call your therapist."))

    def _from_clinic(self) -> "FromClinic | None":
        """Return what comes from the clinic; None if this is no home."""
        if self.letters.role != "home":
            return None
        from sar_tui.app.at_home import FromClinic

        return FromClinic(self, self.patient, self.letters)

    async def _read_letters(self, clinic: "FromClinic") -> None:
        """Tell messages that nobody has read, offer the form that the clinic asks for, and tell
        what it has seen.
        """
        from sar_tui.app.at_home import NOT_RECEIVED, NOT_RECEIVED_WHY

        parameters, _ = access_settings(self.database, self.patient)
        self._tr = tr = app_language(parameters.language)
        try:
            while messages := clinic.unread():
                await self.ask(clinic.show(messages, tr))
                clinic.mark_read(messages)
                self.letters.begin()
            if kind := clinic.form():
                clinic.put_off(kind)  # also if it is left before its end
                if await self.ask(clinic.offer(tr)):
                    await self.fill_form(kind, Occasion(self.patient))
                    self.letters.begin()
            if clinic.is_refused:
                self.notify(NOT_RECEIVED_WHY)
                self.tell(clinic, [tr(NOT_RECEIVED)])
            else:
                self.tell(clinic, clinic.lines(date.today(), tr))
        except (StoreError, PluginError, ParameterError) as error:
            self.notify(str(error))

    def _letters_came(self, done: "Exchanged | StoreError") -> None:
        """Keep what went wrong for the therapist. Called from another thread."""
        found = [str(done)] if isinstance(done, StoreError) else [*done.refused, *done.troubles]
        if self._open_session is None:
            self._troubles += [text for text in found if text not in self._troubles]

    async def _rest(self, *texts: str) -> None:
        """Let the participant rest until a key is pressed."""
        self.tell(object(), sentences(*map(self._tr, texts)))
        self.screen_keys.appeared()
        await self.key(None)

    async def _offer(self, plan: Plan, number: int, total: int, has_more: bool) -> bool:
        """Tell an exercise. Return False if it is skipped."""
        tr = self._tr = planned_language(plan, self.catalogue)
        self.what_next = ""
        if has_more:
            self.what_next = tr(
                "Next: exercise {number} of {total}", number=number + 1, total=total
            )
        place = tr("Exercise {number} of {total}", number=number, total=total) if total > 1 else ""
        skip = f"S: {tr('Skip this exercise')}." if has_more else ""
        start = f"{tr(plan.task.title)}.", tr("Press Enter to start.")
        self.tell(plan, sentences(place, *start, skip))
        self.screen_keys.appeared()
        while True:
            key = await self.key(None)
            if key.key == "enter":
                return True
            if skip and key.key.lower() == "s":
                return False

    # --- the beginning and the end

    async def run(
        self, what: "Plan | str | Callable[[], Coroutine[Any, Any, None]] | None" = None
    ) -> int:
        """Run a session, what a function does, or a participant's exercises; returns the exit
        code.
        """
        self._tr = app_language("en")
        put, code = self._items.put_nowait, 0
        self._catch_signals()
        with (
            PlainTerminal(put, lambda: put(_HANG_UP)) as self._terminal,
            PluginWatchdog(self._abandon),
        ):
            try:
                if callable(what):
                    await what()
                else:
                    await (self._train_alone() if what is None else self.session(what))
            except Ended as ended:
                code = ended.code
            finally:
                self.database.close()
                if code != _HANG_UP:
                    self._say_what_became()
        self.letters.finish()
        live = self._live
        return code or int(bool(self._failure or (live and (live.unsaved or live.rescued))))

    def _catch_signals(self) -> None:
        """End in order on a signal; in patient mode not on those that the terminal's keys send. The
        reading thread notices that the terminal is gone.
        """
        loop = asyncio.get_running_loop()
        if sys.platform == "win32":  # a closed console ends the program, after which is resumed

            def called(number: int, _: object) -> None:
                loop.call_soon_threadsafe(self._signalled, number)

            for number in (signal.SIGINT, signal.SIGBREAK):
                signal.signal(number, called)
        else:
            for number in (signal.SIGINT, signal.SIGQUIT, signal.SIGTERM, signal.SIGHUP):
                loop.add_signal_handler(number, self._signalled, number)

    def _signalled(self, number: int) -> None:
        if not self.patient or number == signal.SIGTERM:
            self._items.put_nowait(after_signal(number))

    def _abandon(self, plugin: str) -> None:
        """End the program at once. From another thread, while this one hangs in the code of a
        plug-in.
        """
        if live := self._open_session:
            live.write_rest()
        self.say(f"The {plugin} does not return from its own code. All earlier trials are kept.")
        self._say_what_became()
        self._terminal.restore()
        os._exit(FAILED)

    def _say_what_became(self) -> None:
        """Say what the therapist must know, and how to get back to the session."""
        for text in dict.fromkeys((*self._troubles, *self._lines_about_session())):
            self._terminal.write(text)

    def _lines_about_session(self) -> Iterator[str]:
        """Return why the last session failed, if it did, and what became of it."""
        if self._failure:
            yield self._failure
        if self._live:
            is_alone = bool(self.patient)
            yield from lines_about(
                self._live, self._command, Language(), is_for_one_session=not is_alone
            )

    def _command(self, name: str, *session: str) -> str:
        line = command_line(self.folder, self.catalogue.extra_tasks, name, *session)
        return f"{line} --plain" if name in ("resume", "study next") else line


class PlainStage:
    """Tells the messages of a session in lines; in place of `SessionStage`.

    Args:
        app: appends the lines, and asks.
        live: the session, which is opened later.

    Attributes:
        gc: keeps the garbage collector off while a response is awaited.
        is_left: True once the participant has left the ended session.
        agent: the agent, whose words are lines, too.
    """

    holds_frames = False

    def __init__(self, app: PlainApp, live: LiveSession) -> None:
        self._app, self._live = app, live
        self.agent = PlainAgent(app)
        self.waiting: Waiting | None = None
        self.is_left = False
        self.gc = GcControl()
        self._typed = self._warned_of = ""
        self._choices: dict[str, str] = {}
        self._choice = ""
        self._is_visited = False

    @functools.cached_property
    def tr(self) -> Language:
        """Language of the session."""
        return session_language(self._live.session.task)

    # --- a prompt

    def show_prompt(self, prompt: Prompt) -> None:
        """Append the prompt, and report its onset: when its line was flushed."""
        self._typed = ""
        self._show(prompt, 0)

    def show_frame(self, prompt: Prompt, frame: int, due: int) -> None:
        """Append a later frame of the prompt, and report when it was flushed."""
        self._show(prompt, frame)

    def _show(self, prompt: Prompt, frame: int) -> None:
        text = prompt.shown(frame).text
        is_told = bool(sentences(text))  # a mark alone, such as a dot, says nothing
        at = self._app.write(text) if is_told else self._live.clock.now()
        self._live.screen.shown(
            Shown(
                attempt=prompt.attempt,
                trial=prompt.trial,
                presentation=prompt.presentation,
                at=at,
                source="flush",
                frame=frame,
            )
        )

    def show_typed(self, prompt: Prompt, text: str) -> None:
        """Append what was typed of a response, which is no line yet."""
        self._echo(text)

    def _echo(self, text: str) -> None:
        self._app.echo(self._typed, text)
        self._typed = text

    def clear_prompt(self) -> None:
        """Go on collecting garbage: the trial is over. Lines stay."""
        self.gc.end_trial()

    def show_trial_feedback(self, feedback: TrialFeedback) -> None:
        """Append the answer to a trial, and report when it was flushed."""
        at = self._app.write(feedback.text)
        shown = TrialFeedbackShown(
            seat=feedback.seat,
            attempt=feedback.attempt,
            trial=feedback.trial,
            at=at,
            source="flush",
        )
        self._live.screen.trial_feedback_shown(shown)

    # --- an attempt, of which the waits tell all

    def begin_attempt(self, started: AttemptStarted) -> None:
        """Collect garbage before the trials."""
        self.gc.begin_attempt()

    def progress(self, done: int) -> None:
        """Do nothing."""

    def marked(self, marked: TrialMarked) -> None:
        """Do nothing."""

    def end_attempt(self, ended: AttemptEnded) -> None:
        """Collect garbage after the trials."""
        self.gc.end_attempt()

    def feedback_given(self, feedback: Feedback) -> None:
        """Do nothing: the agent tells it."""

    def feedback_over(self) -> None:
        """Do nothing."""

    # --- a wait

    def wait(self, waiting: Waiting) -> None:
        """Tell what the session waits for: of the same wait only what is new."""
        before, self.waiting = self.waiting, waiting
        if waiting.what == "response":
            self.gc.begin_trial()
        self._tell_visitors()
        if self._choices:
            self._choices, self._choice = {}, ""
        if waiting.stage != "trial" and (trouble := self._live.trouble) not in (
            "",
            self._warned_of,
        ):
            self._warned_of = trouble
            self._app.notify(trouble)
        if before is None or _place(before) != _place(waiting):
            self._typed = ""
        if waiting.reason == "held":
            let_go = self.tr("Please let go of the keys for a moment.")
            self._app.tell(_place(waiting), [let_go])
        elif waiting.what not in ("foreperiod", "response", "result", "agent", "quiet"):
            self._tell_wait(waiting)

    def visitors_changed(self) -> None:
        """Tell that somebody watches from now on, or does not any longer; the choices in a pause
        change with it.
        """
        self._tell_visitors()
        if self._choices and self.waiting:
            self._open_menu(self.waiting)

    def _tell_visitors(self) -> None:
        is_visited = bool(self._live.visitors)
        if is_visited != self._is_visited and not self.is_in_trial:
            self._is_visited = is_visited
            left = "Your therapist is not watching any longer."
            self._app.say(self.tr(WATCHED if is_visited else left) + "." * is_visited)

    def _tell_wait(self, waiting: Waiting) -> None:
        session, tr = self._live.session, self.tr
        left = max(0, waiting.until - self._live.clock.now())
        decline = ask = ""
        if asked := waiting.step:
            text, decline = step_text(asked, tr, left), decline_text(asked.step, tr)
        elif found := waiting_text(waiting, session.task, left=left):
            text = found
        else:
            if waiting.stage == "paused":
                self._open_menu(waiting)
            return
        if waiting.ask:
            ask = tr("Press {key} to hear how it went.", key=key_name(waiting.ask, tr))
        told = sentences(decline, ask, text.press, self._undo_text)
        self._app.tell(_place(waiting), [*text.sentences, *told])
        if asked and asked.step.kind == "text":
            self._echo(asked.entry.typed)

    @property
    def _undo_text(self) -> str:
        """The key that takes back what was just done; empty if nothing can be."""
        keys = self._live.undo_keys("participant")
        if not keys:
            return ""
        key = self.tr("Backspace") if "backspace" in keys else "Ctrl-Z"
        return f"{key}: {self.tr('Take back')}."

    # --- a pause

    def _open_menu(self, waiting: Waiting) -> None:
        """Tell the choices in a pause, by their numbers."""
        tr, session, reason = self.tr, self._live.session, waiting.reason
        found = pause_choices(
            reason,
            tr,
            can_skip=bool(self._app.patient) and session.can_skip_attempt,
            may_be_mistake=reason == "finished" and self._live.in_first_attempt,
            is_visited=bool(self._live.visitors),
        )
        found.pop("therapist", None)
        self._choices = {str(number): choice for number, choice in enumerate(found, 1)}
        options = [f"{number}: {label}." for number, label in enumerate(found.values(), 1)]
        how = tr("Press the number, then Enter.")
        self._app.tell(_place(waiting), sentences(*pause_words(reason, tr), *options, how))
        self._app.screen_keys.appeared()

    def _choose(self, key: str) -> None:
        """Choose in the menu of a pause: a number, then Enter."""
        if key in self._choices:
            self._choice = key
            self._app.say(self.tr("Chosen: {options}.", options=key))
        elif key == "enter" and self._choice:
            act = act_of(self._choices[self._choice])
            self._choice = ""
            self._live.is_mistake = act.command == "end" and act.reason == "mistake"
            self._live.operate(act)
            if act.reason == "pain" and self._live.session.task.parameters.ask_wellbeing:
                interview = wellbeing.ask_after(self._app, self._live, "pause")
                self._app.later(functools.partial(self.ask_in_pause, interview))

    async def ask_in_pause(self, interview: WellbeingInterview) -> None:
        """Ask about pain; end the session if the participant follows the advice not to go on."""
        if await self._app.ask(interview) is False:
            self._live.operate(SessionCommand(command="end", reason="finished"))
        elif self.waiting and self._choices:
            self._open_menu(self.waiting)

    # --- keys

    @property
    def is_in_trial(self) -> bool:
        """True in a trial, in which no key is held back."""
        return self.waiting is not None and self.waiting.stage == "trial"

    @property
    def judges_keys(self) -> bool:
        """True while the session itself judges which keys count, and records the others."""
        waiting = self.waiting
        return waiting is not None and waiting.what != "nothing" and not self._choices

    def only_chooses(self, key: str) -> bool:
        """Return True if a key chooses in the menu of a pause, which Enter confirms."""
        return key in self._choices

    def pressed(self, key: Key) -> None:
        """Handle a key: a response, a choice, a pause, help, or the end."""
        waiting, session, tr = self.waiting, self._live.session, self.tr
        if waiting is None:
            return
        if key.key == "f1":
            if not self.is_in_trial:
                self._app.say(help_text(session.task, tr, with_marks=False))
        elif self._choices:
            self._choose(key.key)
        elif waiting.what == "nothing":
            if key.key in ("enter", "space"):
                self.is_left = not session.awaits_operator  # who may still veto the goodbye
                self._app.say("" if self.is_left else tr("One moment…"))
        elif key.key == "escape" and waiting.reason == "visit":
            self._live.operate(SessionCommand(command="dismiss"))
        elif key.key == "escape":
            if waiting.what == "sensor" or waiting.stage not in ("paused", "ended"):
                self._live.operate(SessionCommand(command="pause"))
        elif key.key in self._live.undo_keys("participant"):
            if not self._app.screen_keys.is_repeat:
                self._live.undo("participant")
        else:
            stalled = self.gc.is_stalled(round(key.time * SECOND))
            lag = self.gc.lag
            self._live.keyboard.pressed(key.key, key.character, key.time, lag, stalled)

    # --- the end

    def end(self, ended: SessionEnded) -> None:
        """Tell the summary."""
        task, tr = self._live.session.task, self.tr
        status = "mistake" if self._live.is_mistake else ended.status
        bus = self._live.session.bus
        attempts = bus.call(topics.RECALL, Recall(seat=task.seats[0])).attempts
        words = end_of_session(status, bool(attempts), tr)
        told = [words.text] if words.text else facts(attempts, task.metric, tr)
        more = [] if words.text else self._live.view.facts(attempts)
        farewell = ""
        if status not in ("mistake", "refused"):
            days = task.parameters.days_between_visits
            farewell = self._app.what_next or meeting_text(date.today(), days, tr)
        self._app.say(words.headline, *told, *more, farewell, tr("Press Enter to finish."))
        self._app.screen_keys.appeared()


def _place(waiting: Waiting) -> tuple[object, ...]:
    """Tell one wait from the next."""
    about = waiting.step.step.name if waiting.step else ""
    stage, what, reason = waiting.stage, waiting.what, waiting.reason
    return stage, what, reason, waiting.attempt, waiting.trial, about


class PlainAgent:
    """Tells the words of the agent in lines; in place of `SessionAgent`."""

    def __init__(self, app: PlainApp) -> None:
        self._app = app

    def say(
        self, text: str, face: str = "", valence: str | None = None, *, joins: bool = False
    ) -> None:
        self._app.say(text)

    def voiceless(self, action: Action) -> None:
        """Tell the words of an action that could not be spoken."""
        self._app.say(action.text)

    def gesture(self, gesture: Gesture) -> None:
        """Do nothing, as in the others: lines show no face."""

    def gaze(self, where: str) -> None: ...

    def cue(self, gaze: str, gesture: Gesture | None) -> None: ...

    def be_still(self) -> None: ...

    def speaking(self, sounds: bool) -> None: ...

    def look(self, face: str) -> None: ...

    def clear(self, face: str) -> None: ...

    def apply_theme(self, theme: Theme) -> None: ...


def run_plain(
    folder: Path,
    catalogue: Catalogue,
    what: "Plan | str | None" = None,
    patient: str = "",
    link: "BrokerProcess | None" = None,
    markers: Sequence[str] = (),
) -> int:
    """Run a session, or the exercises of a participant, in plain lines; returns the exit code. The
    arguments are as for `PlainApp` and its ``run``.

    Raises:
        StoreError, PluginError, ParameterError, Failed, LinkError: it cannot begin.
    """

    async def run() -> int:
        return await PlainApp(folder, catalogue, patient, link, markers).run(what)

    with asyncio.Runner(loop_factory=punctual_loop) as runner:
        return runner.run(run())


def run_plain_form(
    folder: Path, catalogue: Catalogue, kind: Kind, of: Occasion, language: str = ""
) -> int:
    """Have a participant fill in a form in plain lines; returns the exit code. The arguments are
    those of `app.run_form`.
    """

    async def run() -> int:
        app = PlainApp(folder, catalogue)
        return await app.run(functools.partial(app.fill_form, kind, of, language))

    with asyncio.Runner(loop_factory=punctual_loop) as runner:
        return runner.run(run())
