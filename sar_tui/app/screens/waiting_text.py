"""Texts of the session's screen while it waits for somebody, and while it asks a question."""

from typing import NamedTuple

from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.model.messages import AskedStep, Waiting
from sar_tui.model.results_for_people import duration_text
from sar_tui.model.spoken_text import sentences
from sar_tui.model.step import TIMED, Entry, Point, Step, points
from sar_tui.model.units import SECOND
from sar_tui.tui.language import session_language
from sar_tui.widgets.answer_options import SMALLEST_SCALE, options_text

WATCHED = "Your therapist is watching"
"""Sign that is visible while somebody watches."""


class WaitingText(NamedTuple):
    """Headline, text, and the key to press (empty if no key helps). ``said``: sentences that tell
    the text where it is a drawing; None where it is words.
    """

    headline: str
    text: str
    press: str
    said: tuple[str, ...] | None = None

    @property
    def sentences(self) -> list[str]:
        """Headline and text in sentences."""
        return sentences(self.headline, *((self.text,) if self.said is None else self.said))


def waiting_text(  # noqa: PLR0911, PLR0912
    waiting: Waiting,
    task: Task,
    *,
    left: int = 0,
    is_goal_shown: bool = False,
    is_recording_over: bool = False,
) -> WaitingText | None:
    """Return the text for a wait; None while the screen shows a prompt, the pause menu or the
    summary.

    Args:
        waiting: the wait.
        task: of the session.
        left: time that is left of a rest (ns).
        is_goal_shown: True if the goal, which stays as it was, can be seen beside the last result.
        is_recording_over: True if the sensor that is awaited is a recording at its end.
    """
    tr = session_language(task)
    match waiting.stage:
        case "instructions":
            return WaitingText(tr("Welcome"), task.instructions(), tr("Press Enter to go on."))
        case "attempt":
            return _before_attempt(waiting, tr, is_goal_shown=is_goal_shown)
        case "review":
            press = tr("Press Enter to see how it went.")
            text = waiting.notice or tr("That was the last attempt.")
            return WaitingText(tr("All done"), text, press)
        case "rest":
            return WaitingText(
                tr("A short rest"),
                tr("We go on in {time}.", time=duration_text(-(-left // SECOND), tr)),
                "",
            )
        case "answer":
            return WaitingText(tr("One moment…"), "", "")
        case "trial" if waiting.what == "agent":
            return WaitingText(tr("One moment…"), tr("We go on as soon as I have finished."), "")
        case "trial" if waiting.what == "start":
            press = tr("Press {key} to start.", key=key_name(task.start_key, tr))
            if waiting.notice:
                return WaitingText(tr("Once more"), f"{waiting.notice}\n\n{waiting.goal}", press)
            return WaitingText(tr("Ready?"), waiting.goal, press)
        case "paused" if waiting.reason == "visit":
            return _asked_for_visit(tr)
        case "paused":
            return _paused(waiting, task, tr, is_recording_over)
        case "broken":
            stopped = tr("Something went wrong in this task, so the session has stopped.")
            text = f"{stopped}\n{tr('Everything you did is kept.')}"
            return WaitingText(
                tr("Please fetch the experimenter"), text, tr("Press Enter to close.")
            )
        case "ended" if waiting.reason == "storage":
            return _no_space(waiting.detail, tr)
        case "ended" if waiting.what == "storage":
            return WaitingText(tr("Finished"), tr("Your results are being saved."), "")
    return None


def help_text(task: Task, tr: Language, *, with_marks: bool = True) -> str:
    """Return the instructions of a task, and the keys to pause, to ask for feedback and to mark a
    trial.
    """
    pause = tr("When a screen asks you to, press Enter. To pause, press Escape; nothing is lost.")
    parts = [f"{task.instructions()}\n\n{pause}\n"]
    if task.parameters.feedback_schedule == "request":
        parts.append(tr("To hear how an attempt went, press Tab before the next one.") + "\n")
    if with_marks and (marks := marks_text(task, tr)):
        parts.append(f"\n{marks}\n")
    return "".join(parts)


def marks_text(task: Task, tr: Language) -> str:
    """Return the keys that mark a trial, for the therapist; empty if the task has none."""
    marks = ", ".join(f"{mark.key.upper()} {tr(mark.title)}" for mark in task.marks)
    return tr("For the therapist, during or after a trial: {marks}.", marks=marks) if marks else ""


def key_name(key: str, tr: Language) -> str:
    """Return a key's name on the keyboard: "Space"."""
    return {"space": tr("Space"), "enter": tr("Enter"), "tab": tr("Tab")}.get(key, key.capitalize())


def _before_attempt(waiting: Waiting, tr: Language, *, is_goal_shown: bool) -> WaitingText:
    """Return what is new, and the key; the number of the attempt and its goal where they are not
    seen otherwise.
    """
    if waiting.until:
        begins = tr("The next one begins by itself.")
        press = tr("It begins by itself.") if waiting.attempt == 1 else begins
    elif waiting.attempt == 1:
        press = tr("Press Enter to begin {attempt}.", attempt=waiting.attempt_name)
    else:
        press = tr("Press Enter for {attempt}.", attempt=waiting.attempt_name)
    if is_goal_shown:
        return WaitingText(waiting.notice, waiting.why, press)
    headline = waiting.notice or waiting.attempt_name.capitalize()
    text = f"{waiting.why}\n\n{waiting.goal}" if waiting.why else waiting.goal
    return WaitingText(headline, text, press)


def _paused(
    waiting: Waiting, task: Task, tr: Language, is_recording_over: bool
) -> WaitingText | None:
    match waiting.reason:
        case "interrupted":
            go_on = f"{tr('We go on with {attempt}.', attempt=waiting.attempt_name)} {waiting.goal}"
            return WaitingText(tr("Welcome back"), go_on, tr("Press Enter to go on."))
        case "restored":
            saved = tr("Everything is saved again.")
            if waiting.detail:
                told = tr("For the experimenter: {words}", words=waiting.detail)
                return WaitingText(
                    tr("Please fetch the experimenter"),
                    f"{saved}\n\n{told}",
                    tr("Press Enter to go on."),
                )
            return WaitingText(tr("Thank you for waiting"), saved, tr("Press Enter to go on."))
        case "storage":
            return _no_space(waiting.detail, tr)
        case "sensor":
            why = waiting.detail or tr("The sensor sends nothing. Check its cable.")
            silent = tr("The sensor on your hand sends no data just now. Nothing is lost.")
            if len(task.seats) > 1 and waiting.seat:
                silent = f"{task.display_name(waiting.seat)}: {silent}"
            then = tr(
                "The session goes on by itself once the sensor sends data again. To end it: Escape."
            )
            if is_recording_over:
                then = tr(
                    "A recording replaces the sensor, so the session cannot go on. To end it: "
                    "Escape."
                )
            return WaitingText(
                tr("Please wait"),
                f"{silent}\n\n{tr('For the experimenter: {words}', words=why)}\n{then}",
                "",
            )
    return None


def _asked_for_visit(tr: Language) -> WaitingText:
    what = tr("They see what you do here, and can change the training.")
    return WaitingText(
        tr("Your therapist would like to watch this training"),
        f"{what}\n{tr('You can end this in every pause.')}",
        tr("Enter: yes. Esc: not today."),
    )


def _no_space(detail: str, tr: Language) -> WaitingText:
    return WaitingText(
        tr("Please fetch the experimenter"),
        f"{tr('The computer cannot save just now, so the session has paused.')}\n"
        f"{tr('Please leave this screen open: your last answer may not be saved yet.')}\n\n"
        f"{tr('For the experimenter: {words}', words=detail or tr('The disk cannot be written to.'))}\n"
        f"{tr('When it can be saved again, the session can go on.')}",
        "",
    )


def step_text(
    asked: AskedStep, tr: Language, left: int = 0, columns: int = SMALLEST_SCALE
) -> WaitingText:
    """Return the text for a step.

    Args:
        asked: the step, and what has been chosen so far.
        tr: language of the session.
        left: time that is left of a rest or a calibration (ns).
        columns: room for a scale.
    """
    step = asked.step
    if step.kind in TIMED:
        return WaitingText(
            step.text, tr("We go on in {time}.", time=duration_text(-(-left // SECOND), tr)), ""
        )
    if not step.is_question:
        return WaitingText("", step.text, tr("Press Enter to go on."))
    question = tr("{who}: {words}", who=asked.who, words=step.text) if asked.who else step.text
    options = options_text(step, asked.entry, columns)
    said = option_sentences(step, asked.entry, tr)
    return WaitingText(question, options, how_to_answer(step, asked.entry, tr), said)


def option_sentences(step: Step, entry: Entry, tr: Language) -> tuple[str, ...]:
    """Return the options of a question in sentences, and what is chosen so far. Typed words are
    not said.
    """
    found = points(step)
    said = [f"{point.typed}: {point.label}." for point in found if point.label]
    if step.kind == "line":
        said = [f"{end}: {label}." for end, label in zip(("0", "100"), step.labels, strict=False)]
    if step.kind == "choices" and entry.place is not None:
        said.append(tr("You are at {option}.", option=_option(found[entry.place])))
    if step.kind == "line" and entry.place is not None:
        said.append(tr("Chosen: {options}.", options=str(entry.place)))
    elif entry.chosen:
        chosen = ", ".join(_option(found[index]) for index in entry.chosen)
        said.append(tr("Chosen: {options}.", options=chosen))
    elif step.kind == "choices" and entry.place is not None:
        said.append(tr("Nothing is chosen."))
    return tuple(said)


def _option(point: Point) -> str:
    return f"{point.typed}, {point.label}" if point.label else point.typed


def decline_text(step: Step, tr: Language) -> str:
    """Return how to give no answer to a question; empty if nothing is asked, or a long scale takes
    its place.
    """
    is_said = step.is_question and step.kind != "borg"
    return tr("Press Tab if you would rather not say.") if is_said else ""


def how_to_answer(step: Step, entry: Entry, tr: Language) -> str:
    """Return the keys that answer a question; after Enter without an answer, what is missing."""
    if entry.is_missing:
        return _missing(step, tr)
    match step.kind:
        case "text":
            return tr("Type your answer, then press Enter.")
        case "choices":
            return tr("Press the number of each that fits, then Enter.")
        case "borg":
            return tr(
                "Press a number or an arrow key, then Enter. Press Tab if you would rather not say."
            )
        case "line":
            return tr("Move the mark with the arrow keys, then press Enter.")
    return tr("Press the number or an arrow key, then Enter.")


def _missing(step: Step, tr: Language) -> str:
    match step.kind:
        case "text":
            return tr("Please type your answer first, then press Enter.")
        case "choices":
            return tr("Please choose at least one, then press Enter.")
    return tr("Please choose first, then press Enter.")
