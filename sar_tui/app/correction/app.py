"""The app in which the reaches of one recording are corrected by hand."""

import re
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, Literal

from textual import events, on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static
from textual.widgets.option_list import Option

from sar_tui.app.screen_keys import HelpScreen
from sar_tui.inputs.imu import SourceError
from sar_tui.model.language import Language
from sar_tui.model.theme import Theme
from sar_tui.motion.labels import SURE, Correction, Label, State
from sar_tui.tui.base_app import DESIGN, BaseApp
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.heading import Heading
from sar_tui.tui.key_line import KeyLine
from sar_tui.tui.too_small import TooSmallScreen, cover_if_too_small
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.language import language_of
from sar_tui.widgets.lists import OptionList
from sar_tui.widgets.speed_chart import Span, Speed, SpeedChart, View

STEP_S, STEPS = 0.05, 10
"""Time by which a key moves an edge; with Shift, so many times as far."""
AROUND_S = 3.0
"""Time that is shown before and after a reach."""
CURSOR_S, FAR_S = 1.0, 10.0
"""Times by which keys move the cursor."""
Save = Callable[[Sequence[Label]], None]
"""Stores labels; raises SourceError or OSError if it cannot."""
Answer = Literal["save", "leave", "go on"]


class CorrectionApp(BaseApp):
    """Shows one reach after another, with the keys to correct it.

    Args:
        theme: its colours.
        tr: its language.
        name: of the recording, to show.
        speed: of the recording.
        correction: the labels.
        save: stores them.
    """

    CSS_PATH = [DESIGN, "correction.tcss"]
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("f1,question_mark", "help", "Help", key_display="F1", id="help"),
        Binding("ctrl+q", "quit", "Quit", show=False, priority=True, id="quit"),
    ]

    def __init__(
        self,
        theme: Theme,
        tr: Language,
        name: str,
        speed: Speed,
        correction: Correction,
        save: Save,
    ) -> None:
        self.tr = tr
        super().__init__()
        self.apply_theme(theme)
        self._screen = CorrectionScreen(name, speed, correction, save)

    def on_mount(self) -> None:
        self.push_screen(self._screen)
        cover_if_too_small(self, self.size)

    def on_resize(self, event: events.Resize) -> None:
        cover_if_too_small(self, event.size)

    def action_help(self) -> None:
        """Explain the screen."""
        if not isinstance(self.screen, (HelpScreen, TooSmallScreen)):
            self.push_screen(HelpScreen(self.screen))


class CorrectionScreen(DismissedOnce[None]):
    """One reach at a time: the hand's speed around it, and what is known of it."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "leave", "Back", key_display="Esc", id="leave"),
        Binding("n,right", "next(1)", "Next", key_display="N", id="next"),
        Binding("p,left", "next(-1)", show=False, id="previous"),
        Binding("a,enter", "accept", "Accept", key_display="A", id="accept"),
        Binding("d", "drop", "Drop", key_display="D", id="drop"),
        Binding("i", "insert", "Insert", key_display="I", id="insert"),
        Binding("q,left_square_bracket", "move('start',-1)", "Edges", key_display="QWER", id="q"),
        Binding("w,right_square_bracket", "move('start',1)", show=False, id="w"),
        Binding("e,left_curly_bracket", "move('end',-1)", show=False, id="e"),
        Binding("r,right_curly_bracket", "move('end',1)", show=False, id="r"),
        Binding("Q", f"move('start',-{STEPS})", show=False, id="q-far"),
        Binding("W", f"move('start',{STEPS})", show=False, id="w-far"),
        Binding("E", f"move('end',-{STEPS})", show=False, id="e-far"),
        Binding("R", f"move('end',{STEPS})", show=False, id="r-far"),
        Binding("g", "go_to", "Go to", key_display="G", id="go-to"),
        Binding("u", "unsure", "Unsure", key_display="U", id="unsure"),
        Binding("s,ctrl+s", "save", "Save", key_display="S", id="save"),
        Binding("comma", f"cursor(-{CURSOR_S})", show=False, id="cursor-back"),
        Binding("full_stop", f"cursor({CURSOR_S})", show=False, id="cursor-on"),
        Binding("pageup", f"cursor(-{FAR_S})", show=False, id="cursor-far-back"),
        Binding("pagedown", f"cursor({FAR_S})", show=False, id="cursor-far-on"),
        Binding("home", "first", show=False, id="first"),
        Binding("end", "last", show=False, id="last"),
    ]
    AUTO_FOCUS = ""

    app: Any

    def __init__(self, name: str, speed: Speed, correction: Correction, save: Save) -> None:
        super().__init__()
        self._recording = name
        self._speed, self._correction, self._save = speed, correction, save
        self._only_unsure = False
        self._chosen: int | None = None
        self._at_s = correction.begins_s
        self._view = (0.0, 1.0)
        self._has_cursor = False

    @property
    def help_text(self) -> str:
        """Help on the picture and the keys."""
        tr = self.app.tr
        paragraphs = (
            tr(
                "The picture shows how fast the hand turned. The vertical lines are the start and "
                "the end of the reach. Say of each one whether it is a reach, and save with S."
            ),
            tr(
                "N and P: the next one, the one before. A: it is a reach. D: it is none; D again "
                "takes that back. Q and W move its start, "
                "E and R its end, with Shift ten times as far; [ ] and { } do the same."
            ),
            tr(
                "A reach that is missing: go there with G and a time, or with comma, full stop, "
                "Page Up and Page Down. I adds a reach at the mark below the picture."
            ),
            tr("U: only reaches of which the program is not sure. Home and End: first and last."),
        )
        return "\n\n".join(paragraphs) + "\n"

    def compose(self) -> ComposeResult:
        with Horizontal(classes="top-bar"):
            yield Static(self._recording, id="who", markup=False)
            yield Static("", id="where", markup=False)
        yield Heading("", id="sentence")
        yield Static("", id="facts", classes="body", markup=False)
        yield SpeedChart(self._speed, self._clock, id="chart")
        yield Static("", id="told", classes="needs-a-look", markup=False)
        yield KeyLine()
        yield KeyFooter(show_command_palette=False, optional=("help", "accept", "go_to"))

    def on_mount(self) -> None:
        first = self._correction.next(1, after=-1, at_s=0.0)
        if first is None:
            self._go(self._correction.begins_s)
        else:
            self._choose(first)

    # --- what is shown

    def _choose(self, index: int) -> None:
        """Show a reach."""
        label = self._correction.labels[index]
        self._chosen, self._has_cursor = index, False
        self._at_s = (label.start_s + label.end_s) / 2
        self._view = (label.start_s - AROUND_S, label.end_s + AROUND_S)
        self._show()

    def _go(self, at_s: float) -> None:
        """Show a time, with the cursor at it, and the reach that is there."""
        correction = self._correction
        self._at_s = min(max(at_s, correction.begins_s), correction.ends_s)
        self._chosen, self._has_cursor = correction.at(self._at_s), True
        from_s, to_s = self._view
        if not from_s + CURSOR_S <= self._at_s <= to_s - CURSOR_S:
            self._view = (self._at_s - FAR_S / 2, self._at_s + FAR_S / 2)
        self._show()

    def _show(self, told: str = "") -> None:
        """Show what is chosen, and a sentence on the last key."""
        tr, chosen = self.app.tr, self._label
        sentence, key = _said(chosen, tr)
        if not self._correction.labels:
            sentence = tr("No reach was found in this recording.")
        self.query_one("#where", Static).update(self._where())
        self.query_one(Heading).show(sentence)
        self.query_one("#facts", Static).update(self._facts())
        self.query_one("#told", Static).update(told)
        self.query_one(KeyLine).show(key, key.partition(":")[0])
        from_s, to_s = self._view
        spans = tuple(
            Span(
                label.start_s,
                label.end_s,
                f"{index + 1}" if label.counts else f"× {index + 1}",
                index == self._chosen,
            )
            for index, label in enumerate(self._correction.labels)
            if label.end_s >= from_s and label.start_s <= to_s
        )
        cursor_s = self._at_s if self._has_cursor else None
        self.query_one(SpeedChart).show(View(from_s, to_s, spans, cursor_s))

    @property
    def _label(self) -> Label | None:
        return None if self._chosen is None else self._correction.labels[self._chosen]

    def _where(self) -> str:
        """Return which one of how many is shown, and how many have been looked at."""
        tr, labels = self.app.tr, self._correction.labels
        listed = [at for at, label in enumerate(labels) if label.is_unsure or not self._only_unsure]
        done = sum(labels[at].state != "found" for at in listed)
        number = listed.index(self._chosen) + 1 if self._chosen in listed else "–"
        slots = {"number": number, "count": len(listed)}
        parts = [
            tr("Unsure {number} of {count}", **slots)
            if self._only_unsure
            else tr("Reach {number} of {count}", **slots),
            tr("{done} looked at", done=done),
            *([tr("not saved")] if self._correction.is_changed else []),
        ]
        return " · ".join(parts)

    def _facts(self) -> str:
        tr, label = self.app.tr, self._label
        if label is None:
            return self._clock(self._at_s, 1)
        lasts = tr("{seconds} s", seconds=f"{label.reach_time_s:.2f}")
        times = tr(
            "{start} to {end}",
            start=self._clock(label.start_s, 2),
            end=self._clock(label.end_s, 2),
        )
        parts = (times, lasts, _sureness(label, tr), tr(_STATES[label.state]))
        return " · ".join(filter(None, parts))

    def _clock(self, time_s: float, digits: int = 0) -> str:
        """Return a time since the beginning of the recording: ``1:02:03.4``."""
        unit = 10**digits
        whole = round((time_s - self._correction.begins_s) * unit)
        sign, (seconds, rest) = "−" if whole < 0 else "", divmod(abs(whole), unit)
        minutes, seconds = divmod(seconds, 60)
        hours, minutes = divmod(minutes, 60)
        text = f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"
        if digits:
            mark: str = self.app.tr.figures("0.5")[1]
            text += f"{mark}{rest:0{digits}}"
        return sign + text

    # --- keys

    def action_next(self, step: int) -> None:
        """Show the next reach, or the one before."""
        index = self._correction.next(
            step, after=self._chosen, at_s=self._at_s, only_unsure=self._only_unsure
        )
        if index is not None:
            self._choose(index)
        elif step > 0:
            self._show(self.app.tr("There is no reach after this one."))
        else:
            self._show(self.app.tr("There is no reach before this one."))

    def action_first(self) -> None:
        """Show the first reach."""
        self._end(1, after=-1)

    def action_last(self) -> None:
        """Show the last reach."""
        self._end(-1, after=len(self._correction.labels))

    def _end(self, step: int, after: int) -> None:
        index = self._correction.next(step, after=after, at_s=0.0, only_unsure=self._only_unsure)
        if index is not None:
            self._choose(index)

    def action_accept(self) -> None:
        """Confirm the reach, and show the next one."""
        if self._chosen is None:
            self._show(self.app.tr("There is no reach here. I adds one."))
            return
        index = self._correction.accept(self._chosen)
        if index is None:
            self._show(self.app.tr("It overlaps another reach: drop that one first."))
            return
        self._chosen = index
        self.action_next(1)

    def action_drop(self) -> None:
        """Drop the reach, or take that back."""
        if self._chosen is None:
            self._show(self.app.tr("There is no reach here. I adds one."))
            return
        index = self._correction.drop(self._chosen)
        if index is None:
            self._show(self.app.tr("It overlaps another reach: drop that one first."))
            return
        self._chosen = index
        self._show()

    def action_insert(self) -> None:
        """Add a reach at the cursor."""
        index = self._correction.insert(self._at_s)
        if index is None:
            self._show(self.app.tr("There is no room for another reach here."))
            return
        self._choose(index)

    def action_move(self, edge: Literal["start", "end"], steps: int) -> None:
        """Move an edge of the reach."""
        if self._chosen is None:
            self._show(self.app.tr("There is no reach here. I adds one."))
            return
        if self._label and not self._label.counts:
            self._show(self.app.tr("It is dropped. D takes that back."))
            return
        index = self._correction.move(self._chosen, edge, steps * STEP_S)
        if index is None:
            self._show(self.app.tr("There is no room to move it farther."))
            return
        self._chosen, self._has_cursor = index, False
        label, (from_s, to_s) = self._correction.labels[index], self._view
        self._at_s = (label.start_s + label.end_s) / 2
        if label.start_s < from_s + STEP_S or label.end_s > to_s - STEP_S:
            self._view = (label.start_s - AROUND_S, label.end_s + AROUND_S)
        self._show()

    def action_cursor(self, by_s: float) -> None:
        """Move the cursor."""
        self._go(self._at_s + by_s)

    def action_unsure(self) -> None:
        """Go through the unsure reaches only, or through all again."""
        if not self._only_unsure and not any(label.is_unsure for label in self._correction.labels):
            self._show(self.app.tr("The program is sure of all reaches."))
            return
        self._only_unsure = not self._only_unsure
        label = self._label
        if not self._only_unsure or (label and label.is_unsure):
            self._show()
            return
        index = self._correction.next(1, after=self._chosen, at_s=self._at_s, only_unsure=True)
        if index is None:
            self.action_first()
        else:
            self._choose(index)

    def action_go_to(self) -> None:
        """Ask for a time, and show it."""

        def go(text: str | None) -> None:
            seconds = seconds_of(text or "")
            if seconds is not None:
                self._go(self._correction.begins_s + seconds)

        self.app.push_screen(GoToScreen(), go)

    def action_save(self) -> None:
        """Store the labels."""
        self.save()

    def save(self) -> bool:
        """Store the labels, and return True; say why if that is not possible."""
        tr = self.app.tr
        try:
            self._save(self._correction.labels)
        except (SourceError, OSError) as error:
            why = getattr(error, "strerror", None) or str(error)
            self._show(tr("It is not saved: {why}", why=why))
            return False
        self._correction.saved()
        self._show(tr("It is saved."))
        return True

    def action_leave(self) -> None:
        """Leave the app; ask first if something is not saved."""
        if self.may_quit():
            self.app.exit()

    def may_quit(self) -> bool:
        """Return True if everything is saved; ask otherwise."""
        if not self._correction.is_changed:
            return True
        self.app.push_screen(UnsavedScreen(), self._answered)
        return False

    def _answered(self, answer: Answer | None) -> None:
        if answer == "leave" or (answer == "save" and self.save()):
            self.app.exit()


_STATES: dict[State, str] = {
    "found": "not looked at yet",
    "accepted": "accepted",
    "dropped": "dropped",
    "moved": "moved",
    "added": "added by hand",
}


def _said(label: Label | None, tr: Language) -> tuple[str, str]:
    """Return the sentence on a reach, and the one key."""
    on = tr("Enter: on to the next")
    match label.state if label else "":
        case "found":
            return tr("Is this one reach?"), tr("Enter: yes, and on to the next")
        case "accepted":
            return tr("This is a reach."), on
        case "dropped":
            return tr("This is no reach."), tr("D: take it back")
        case "moved":
            return tr("This is a reach, with its edges moved."), on
        case "added":
            return tr("This is a reach that was missing."), on
    return tr("No reach was found here."), tr("I: add a reach here")


def _sureness(label: Label, tr: Language) -> str:
    """Return how sure the detector was, in words; empty if that is not known."""
    if label.confidence is None:
        return ""
    if label.is_unsure:
        return tr("unsure")
    return tr("sure") if label.confidence >= SURE else tr("fairly sure")


def seconds_of(text: str) -> float | None:
    """Return a time that was typed, such as ``1:02:03.5``, ``2:03`` or ``123``, in s; None if it is
    none.
    """
    if not re.fullmatch(r"(\d{1,6}:){0,2}\d{1,9}([.,]\d{1,6})?", text.strip(), re.ASCII):
        return None
    seconds = 0.0
    for part in text.strip().replace(",", ".").split(":"):
        seconds = 60 * seconds + float(part)
    return seconds


class GoToScreen(DismissedOnce[str | None], ModalScreen[str | None]):
    """Asks for a time in the recording; its result is the text, or None."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Cancel", id="cancel")
    ]

    app: Any

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        with Vertical(classes="dialog"):
            yield Static(tr("Which time in the recording?"), classes="headline", markup=False)
            yield Input(placeholder="12:30", max_length=20)
            yield Static("", id="problem", classes="needs-a-look", markup=False)
            yield Static(tr("Press Enter to go there, Esc to cancel."), classes="muted")

    @on(Input.Submitted)
    def _go(self, event: Input.Submitted) -> None:
        if seconds_of(event.value) is None:
            tr = language_of(self.app)
            said = tr("Type minutes and seconds, such as 12:30.")
            self.query_one("#problem", Static).update(said)
        else:
            self.dismiss(event.value)


class UnsavedScreen(DismissedOnce[Answer], ModalScreen[Answer]):
    """Asks what to do with labels that are not saved."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss('go on')", "Go on", id="go-on")
    ]

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        menu = OptionList(
            Option(tr("Save and leave"), id="save"),
            Option(tr("Leave without saving"), id="leave"),
            Option(tr("Go on"), id="go on"),
            id="unsaved",
            markup=False,
        )
        menu.border_title = tr("Your corrections are not saved.")
        menu.border_subtitle = tr("arrows to choose, Enter to confirm")
        menu.highlighted = 0
        yield menu

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        event.stop()
        answers: dict[str | None, Answer] = {"save": "save", "leave": "leave"}
        self.dismiss(answers.get(event.option.id, "go on"))
