"""A session for screen readers and braille: lines that are appended one at a time, and nothing else.

It has the loop, the texts, the keys and the record of any other session.
"""

import asyncio
import contextlib
import functools
import shlex
import signal
import threading
from collections.abc import Callable, Sequence
from datetime import date
from pathlib import Path
from typing import Any

from sar_tui.app import wellbeing
from sar_tui.app.live import LAST_WRITE_SECONDS, LiveSession
from sar_tui.app.plain_terminal import Key, PlainTerminal
from sar_tui.app.prompt_needs import PROMPTS, prompts_of, refusal
from sar_tui.app.screens.pause import act_of, pause_choices, pause_words
from sar_tui.app.screens.summary import ending as end_of_session
from sar_tui.app.screens.summary import facts
from sar_tui.app.screens.waiting_text import (
    decline_text,
    how_to_answer,
    key_name,
    option_sentences,
    step_text,
    waiting_text,
)
from sar_tui.app.screens.wellbeing import GO_ON_KEY, QUESTIONS, Questions
from sar_tui.loop import topics
from sar_tui.loop.bus import FAULT
from sar_tui.loop.clock import LiveClock
from sar_tui.loop.task import Task
from sar_tui.model.gesture import Gesture
from sar_tui.model.language import Language
from sar_tui.model.messages import (
    Action,
    AttemptEnded,
    AttemptStarted,
    Fault,
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
from sar_tui.model.step import Entry, Given, points, press, translated
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import EnoughToday, Plan, set_up
from sar_tui.store import records
from sar_tui.store.database import StoreError, connect, default_folder
from sar_tui.store.training_days import utc
from sar_tui.store.wellbeing import NOT_SAID
from sar_tui.tui.base_app import punctual_loop
from sar_tui.tui.exit_codes import FAILED, INTERRUPTED, after_signal
from sar_tui.tui.gc_control import GcControl
from sar_tui.tui.language import app_language, planned_language, session_language
from sar_tui.widgets.task_view import TaskView, view_of

Item = Key | int | Callable[[], Any]
"""A key, an exit code with which to end, or something to be done in between."""


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
    """

    def __init__(self, folder: Path, catalogue: Catalogue, patient: str = "") -> None:
        self.folder, self.catalogue, self.patient = folder, catalogue, patient
        self.database = connect(folder)
        self.what_next = ""
        self._keys: asyncio.Queue[Item] = asyncio.Queue()
        self._terminal: PlainTerminal
        self._live: LiveSession | None = None
        self._failure = ""

    # --- lines

    def say(self, *texts: str) -> int:
        """Append each sentence as a line, and return when the last was written (ns)."""
        at = 0
        for sentence in sentences(*texts):
            at = self._terminal.write(sentence)
        return at

    def write(self, text: str) -> int:
        """Append a text as one line, and return when it was written (ns)."""
        return self._terminal.write(text)

    def notify(self, message: str, /, *, severity: Any = "", timeout: float | None = None) -> None:
        """Append a message for the therapist."""
        self.say(message)

    # --- keys

    async def key(self) -> Key:
        """Return the next key. Raises Ended if it ends the program."""
        while True:
            item = await self._keys.get()
            if isinstance(item, int):
                raise Ended(item)
            if not isinstance(item, Key):
                await item()
            elif item.name in ("ctrl+c", "ctrl+q"):
                self._leave(item.name)
            elif item.name == "f12" and self.patient:
                await self._ask_passphrase()
            else:
                return item

    def later(self, do: Callable[[], Any]) -> None:
        """Have something done before the next key."""
        self._keys.put_nowait(do)

    def _leave(self, key: str) -> None:
        """End the program; in patient mode, pause the session."""
        if not self.patient:
            raise Ended(INTERRUPTED if key == "ctrl+c" else 0)
        if self._live and not self._live.session.ended:
            self._live.operate(SessionCommand(command="pause"))

    async def _ask_passphrase(self) -> None:
        """End patient mode if the passphrase is right."""
        from sar_tui.store.passphrase import Passphrase

        if self._live and not self._live.session.ended:
            self._live.operate(SessionCommand(command="pause"))
        tr, passphrase = app_language("en"), Passphrase(self.folder)
        self.say(tr("For the therapist"), tr("Please enter the passphrase."))
        typed = ""
        while not (isinstance(item := await self._keys.get(), Key) and item.name == "enter"):
            if isinstance(item, int):
                raise Ended(item)
            if isinstance(item, Key):
                typed = typed[:-1] if item.name == "backspace" else typed + item.character
            else:
                await item()
        if passphrase.check(typed, "patient mode"):
            raise Ended(0)
        self.say(tr("That is not the passphrase."))

    # --- questions

    async def ask(self, questions: Questions) -> bool:
        """Ask about pain and tiredness. Return False if the advice to stop is followed."""
        tr, told = questions.tr, questions.told
        asked: tuple[Any, Any] | None = (questions.people[0], "pain") if told is None else None
        pain = {questions.people[0].seat: str(told)} if told is not None else {}
        while asked:
            person, question = asked
            answer = await self._answer_of(person.name, question, tr)
            if answer is None:  # the rest is left out
                break
            questions.save(person, question, answer)
            if question == "pain":
                pain[person.seat] = answer
            asked = questions.after(person, question, answer)
        hurt = [
            one for one in questions.people if questions.is_too_much(one, pain.get(one.seat, ""))
        ]
        return not hurt or await self._advise(questions, hurt)

    async def _answer_of(self, name: str, question: Any, tr: Language) -> str | None:
        step, entry = translated(QUESTIONS[question], tr), Entry()
        options = option_sentences(step, entry, tr)
        self.say(name, step.text, *options, decline_text(step, tr), how_to_answer(step, entry, tr))
        while True:
            key = await self.key()
            if key.name == "escape":
                return None
            pressed = press(step, entry, key.character.strip() or key.name)
            if isinstance(pressed, Given):
                if pressed.answer is None:
                    return NOT_SAID
                return str(points(QUESTIONS[question])[entry.chosen[0]].value)
            if pressed.is_missing:
                self.say(how_to_answer(step, pressed, tr))
            elif pressed.chosen and pressed.chosen != entry.chosen:
                self.say(option_sentences(step, pressed, tr)[-1])
            entry = pressed

    async def _advise(self, questions: Questions, hurt: Sequence[Any]) -> bool:
        for person in hurt:
            questions.save(person, "advice", "shown")
        heading, told, go_on, stop = questions.advice
        self.say(heading, told, go_on, stop)
        while True:
            key = await self.key()
            goes_on = bool(go_on) and key.name.lower() == GO_ON_KEY
            if key.name in ("enter", "escape") or goes_on:
                break
        if questions.moment == "after":
            return True
        for person in hurt:
            questions.save(person, "advice", "went on" if goes_on else "stopped")
        return goes_on

    # --- a session

    async def session(self, what: "Plan | str") -> bool:
        """Run a new session (a plan), or an interrupted one (its id). Return True if it was ended.

        Raises:
            StoreError, PluginError, ParameterError, Failed: it cannot begin.
        """
        asked_since = ""
        if isinstance(what, Plan) and what.parameters.ask_wellbeing:
            asked_since = utc()
            theme = self.catalogue.theme(what.theme, what.parameters.language)
            task = set_up(what.task, what.parameters)
            codes = list(what.participants)
            if not await self.ask(wellbeing.ask_before(self, task, theme, codes)):
                return False
        loop = asyncio.get_running_loop()
        clock = LiveClock(loop)

        def refuse(task: Task, seed: int) -> str:
            return untold(task, seed) or refusal(task, seed, no_color=True)

        live = LiveSession(self.folder, self.catalogue, clock, refusal=refuse, is_plain=True)
        stage = PlainStage(self, live)
        live.open(stage, what)
        if asked_since:
            with contextlib.suppress(StoreError):  # they stay with the participant
                records.attach(self.database, live.run.id, list(live.codes.values()), asked_since)
        await self._play(live, stage, clock)
        if self._failure:
            self.say(self._failure)
        elif live.asks_after:
            await self.ask(wellbeing.ask_after(self, live))
        if not self.patient:
            for text in wellbeing.warnings(self, list(live.codes.values())):
                self.notify(text)
        return live.session.ended and not live.is_mistake

    async def _play(self, live: LiveSession, stage: "PlainStage", clock: LiveClock) -> None:
        """Run a session to its end, and close it, whatever happens."""
        self._live, bus = live, live.session.bus

        def faulted(fault: Fault) -> None:
            if live.session.broken is fault:
                self._failure = (
                    f"The task failed ({fault.error}, {fault.place}). What was done so far is kept."
                )

        def step_ended(ended: StepEnded) -> None:
            if advice := wellbeing.advise(self, live, ended):
                live.operate(SessionCommand(command="pause", reason="pain", seat=ended.seat))
                self.later(functools.partial(stage.ask_in_pause, advice))

        bus.subscribe(FAULT, faulted)
        bus.subscribe(topics.STEP_ENDED, step_ended)
        running = asyncio.get_running_loop().create_task(clock.run())
        running.add_done_callback(self._stopped)
        writing = threading.Thread(target=live.store, name="storage", daemon=True)
        writing.start()
        clock.call_soon(live.run.begin)
        try:
            while not stage.is_left:
                stage.pressed(await self.key())
        finally:
            stage.gc.end_attempt()
            running.cancel()
            live.release()
            live.write_rest()
            live.finish()
            writing.join(LAST_WRITE_SECONDS)
            self._live = None

    def _stopped(self, running: "asyncio.Task[None]") -> None:
        """End the program if the session's loop has failed."""
        if not running.cancelled() and (error := running.exception()):
            self._failure = f"The session failed ({error}). What was done so far is kept."
            self._keys.put_nowait(FAILED)

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

        names = exercises(self.database, self.folder, self.catalogue, self.patient)
        troubles: list[str] = []
        skipped: set[str] = set()
        try:
            while True:
                today = date.today()
                day = day_plan(self.database, self.folder, self.patient, names, today)
                to_do = [one for one in day if not (one.is_done or one.name in skipped)]
                if not to_do:
                    tr = app_language("en") if not day else self._tr
                    self.say(tr("That was everything. Well done!"), tr("You can rest now."))
                    skipped = set(names)
                    await self.key()
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
                except EnoughToday:
                    continue
                except PLAN_ERRORS as error:
                    troubles.append(str(error))
                    self.say(self._tr("This does not work now. Please call your therapist."))
        finally:
            for text in dict.fromkeys(troubles):
                self.notify(text)

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
        self.say(place, f"{tr(plan.task.title)}.", tr("Press Enter to start."), skip)
        while True:
            key = await self.key()
            if key.name == "enter":
                return True
            if skip and key.name.lower() == "s":
                return False

    # --- the beginning and the end

    async def run(self, what: "Plan | str | None" = None) -> int:
        """Run a session, or a participant's exercises; returns the exit code."""
        self._tr = app_language("en")
        end = self._keys.put_nowait
        lost = after_signal(getattr(signal, "SIGHUP", 1))
        self._catch_signals()
        code, session = 0, ""
        with PlainTerminal(end, lambda: end(lost)) as self._terminal:
            try:
                if what is None:
                    await self._train_alone()
                else:
                    session = what.id if isinstance(what, Plan) else what
                    is_ended = await self.session(what)
                    code = FAILED if self._failure else 0
                    self._say_kept(session, is_ended)
            except Ended as ended:
                code = ended.code
                if session and code != lost:
                    self._say_kept(session, False)
            finally:
                self.database.close()
        return code

    def _catch_signals(self) -> None:
        """End in order on a signal; in patient mode not on those that the terminal's keys send. The
        reading thread notices that the terminal is gone.
        """
        loop = asyncio.get_running_loop()
        for name in ("SIGTERM", "SIGHUP", "SIGINT"):
            with contextlib.suppress(AttributeError, NotImplementedError):  # Windows
                number = getattr(signal, name)
                is_held_back = self.patient and name != "SIGTERM"
                do = (lambda _: None) if is_held_back else self._keys.put_nowait
                loop.add_signal_handler(number, do, after_signal(number))

    def _say_kept(self, session: str, is_ended: bool) -> None:
        """Say where the session is, if it has begun."""
        row = self.database.execute("SELECT status FROM sessions WHERE id=?", (session,)).fetchone()
        if row is None:
            return
        name, doing = ("show", "Look at it") if is_ended else ("resume", "Resume it")
        parts = ["sar-tui", name, session, *([] if is_ended else ["--plain"])]
        if self.folder.resolve() != default_folder().resolve():
            parts += ["--data", str(self.folder)]
        self._terminal.write(f"The session is kept. {doing}: {shlex.join(parts)}")


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
        self._place: object = None
        self._told: tuple[str, ...] = ()
        self._choices: dict[str, str] = {}
        self._choice = ""

    @functools.cached_property
    def tr(self) -> Language:
        """Language of the session."""
        return session_language(self._live.session.task)

    # --- a prompt

    def show_prompt(self, prompt: Prompt) -> None:
        """Append the prompt, and report its onset: when its line was flushed."""
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
        """Do nothing: no line may come while a response is awaited."""

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
        self.waiting = waiting
        if waiting.what == "response":
            self.gc.begin_trial()
        self._choices = {}
        about = waiting.step.step.name if waiting.step else ""
        place = (waiting.stage, waiting.what, waiting.reason, waiting.attempt, waiting.trial, about)
        if place != self._place:
            self._place, self._told = place, ()
        if waiting.reason == "held":
            self._tell(self.tr("Please let go of the keys for a moment."))
        elif waiting.what not in ("foreperiod", "response", "result", "agent", "quiet"):
            self._tell_wait(waiting)

    def _tell_wait(self, waiting: Waiting) -> None:
        session, tr = self._live.session, self.tr
        left = max(0, waiting.until - self._live.clock.now())
        if waiting.step:
            text, decline = step_text(waiting.step, tr, left), decline_text(waiting.step.step, tr)
        else:
            found = waiting_text(waiting, session.task, left=left)
            decline = ""
            if found is None:
                if waiting.stage == "paused":
                    self._open_menu(waiting.reason)
                return
            text = found
        ask = ""
        if waiting.ask:
            ask = tr("Press {key} to hear how it went.", key=key_name(waiting.ask, tr))
        self._tell(text.headline, *(text.said or [text.text]), decline, ask, text.press)

    def _tell(self, *texts: str) -> None:
        found = sentences(*texts)
        self._app.say(*(each for each in found if each not in self._told))
        self._told = tuple(found)

    # --- a pause

    def _open_menu(self, reason: str) -> None:
        """Tell the choices in a pause, by their numbers."""
        tr, session = self.tr, self._live.session
        found = pause_choices(
            reason,
            tr,
            can_skip=bool(self._app.patient) and session.can_skip_attempt,
            may_be_mistake=reason == "finished" and self._live.in_first_attempt,
        )
        found.pop("therapist", None)
        self._choices = {str(number): choice for number, choice in enumerate(found, 1)}
        self._choice = ""
        options = [f"{number}: {label}." for number, label in enumerate(found.values(), 1)]
        how = tr("Press the number, then Enter.")
        self._tell(*pause_words(reason, tr), *options, how)

    def _choose(self, key: Key) -> None:
        """Choose in the menu of a pause: a number, then Enter."""
        if key.name in self._choices:
            self._choice = key.name
            self._app.say(self.tr("Chosen: {options}.", options=key.name))
        elif key.name == "enter" and self._choice:
            act = act_of(self._choices[self._choice])
            self._choice = ""
            self._live.is_mistake = act.command == "end" and act.reason == "mistake"
            self._live.operate(act)
            if act.reason == "pain" and self._live.session.task.parameters.ask_wellbeing:
                questions = wellbeing.ask_after(self._app, self._live, "pause")
                self._app.later(functools.partial(self.ask_in_pause, questions))

    async def ask_in_pause(self, questions: Questions) -> None:
        """Ask about pain; end the session if the participant follows the advice not to go on."""
        if await self._app.ask(questions):
            if self.waiting and self._choices:
                self._told = ()
                self._open_menu(self.waiting.reason)
        else:
            self._live.operate(SessionCommand(command="end", reason="finished"))

    # --- keys

    def pressed(self, key: Key) -> None:
        """Handle a key: a response, a choice, a pause, or the end."""
        waiting = self.waiting
        if waiting is None:
            return
        if self._choices:
            self._choose(key)
        elif waiting.what == "nothing":
            self.is_left = key.name in ("enter", "space")
        elif key.name == "escape":
            if waiting.what == "sensor" or waiting.stage not in ("paused", "ended"):
                self._live.operate(SessionCommand(command="pause"))
        else:
            lag, stalled = self.gc.lag, self.gc.is_stalled(key.at)
            at = key.at / SECOND
            self._live.keyboard.pressed(key.name, key.character or None, at, lag, stalled)

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
    folder: Path, catalogue: Catalogue, what: "Plan | str | None" = None, patient: str = ""
) -> int:
    """Run a session, or the exercises of a participant, in plain lines; returns the exit code.

    Raises:
        StoreError, PluginError, ParameterError, Failed: it cannot begin.
    """

    async def run() -> int:
        return await PlainApp(folder, catalogue, patient).run(what)

    with asyncio.Runner(loop_factory=punctual_loop) as runner:
        return runner.run(run())
