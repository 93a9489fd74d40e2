"""The screen on which reaches are corrected by hand, one at a time."""

from collections.abc import Callable, Sequence
from typing import Any, ClassVar, Literal

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.timer import Timer
from textual.widgets import Static

from sar_tui.app.correction.dialogs import Answer, GoToScreen, UnsavedScreen
from sar_tui.inputs.imu import SourceError
from sar_tui.model.language import Language
from sar_tui.motion.labels import SURE, Correction, Label, State
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.heading import Heading
from sar_tui.tui.key_line import KeyLine
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.speed_chart import Span, Speed, SpeedChart, View

STEP_S, STEPS = 0.05, 10
"""Time by which a key moves an edge; with Shift, so many times as far."""
AROUND_S = (0.75, 1.5, 3.0, 6.0, 12.0, 30.0, 60.0)
"""Times that can be shown before and after a reach; the third is shown first."""
CURSOR_S, FAR_S = 1.0, 10.0
"""Times by which keys move the cursor."""
SAVE_AFTER_S = 0.1
"""A correction is saved so soon, together with those that a held key makes until then."""
HELD_S = 0.15
"""A key that comes sooner after it has accepted a reach is held: nobody has looked at the next one
yet.
"""
Save = Callable[[Sequence[Label]], None]
"""Stores labels; raises SourceError or OSError if it cannot."""


class CorrectionScreen(DismissedOnce[None]):
    """One reach at a time: the hand's speed around it, and what is known of it."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "leave", "Back", key_display="Esc", id="leave"),
        Binding("n,N,right", "next(1)", "Next", key_display="N", id="next"),
        Binding("p,P,left", "next(-1)", show=False, id="previous"),
        Binding("enter", "go_on", show=False, id="go-on"),
        Binding("a,A", "accept", "Accept", key_display="A", id="accept"),
        Binding("d,D", "drop", "Drop", key_display="D", id="drop"),
        Binding("i,I", "insert", "Insert", key_display="I", id="insert"),
        Binding("q", "move('start',-1)", "Onset", key_display="QW", id="q"),
        Binding("w", "move('start',1)", show=False, id="w"),
        Binding("e", "move('end',-1)", "End", key_display="ER", id="e"),
        Binding("r", "move('end',1)", show=False, id="r"),
        Binding("Q", f"move('start',-{STEPS})", show=False, id="q-far"),
        Binding("W", f"move('start',{STEPS})", show=False, id="w-far"),
        Binding("E", f"move('end',-{STEPS})", show=False, id="e-far"),
        Binding("R", f"move('end',{STEPS})", show=False, id="r-far"),
        Binding("g,G", "go_to", "Go to", key_display="G", id="go-to"),
        Binding("u,U", "unsure", "Unsure", key_display="U", id="unsure"),
        Binding("z,Z,ctrl+z,backspace", "undo", "Undo", key_display="Z", id="undo"),
        Binding("s,S,ctrl+s", "save", show=False, id="save"),
        Binding("plus,equals_sign", "zoom(-1)", show=False, id="zoom-in"),
        Binding("minus", "zoom(1)", show=False, id="zoom-out"),
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
        self._zoom = 2
        self._view = (0.0, 1.0)
        self._has_cursor = False
        self._accepted_s = -HELD_S
        self._saving: Timer | None = None
        self._has_saved, self._why_unsaved = False, ""

    @property
    def help_text(self) -> str:
        """Help on the picture and the keys."""
        tr = self.app.tr
        paragraphs = (
            tr(
                "The picture shows how fast the hand turned. The vertical lines are the start and "
                "the end of the reach. Say of each one whether it is a reach. All that you change "
                "is saved at once; Z takes it back."
            ),
            tr(
                "A: it is a reach. D: it is none; D again takes that back. Q and W move its start, "
                "E and R its end, with Shift ten times as far. N and P: the next one, the one "
                "before. Home and End: first and last."
            ),
            tr(
                "A reach that is missing: go there with G and a time, or with comma, full stop, "
                "Page Up and Page Down. I adds a reach at the mark below the picture."
            ),
            tr(
                "U: only reaches of which the program is not sure. Plus and minus show a shorter "
                "or longer time."
            ),
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
        yield KeyFooter(
            show_command_palette=False, optional=("accept", "insert", "go_to", "next(1)", "help")
        )

    def on_mount(self) -> None:
        labels = self._correction.labels
        waiting = (index for index, label in enumerate(labels) if label.state == "found")
        first = next(waiting, 0 if labels else None)
        if first is None:
            self._go(self._correction.begins_s)
        else:
            self._choose(first)

    # --- what is shown

    def _choose(self, index: int) -> None:
        """Show a reach."""
        label = self._correction.labels[index]
        self._chosen, self._has_cursor = index, False
        self._at_s = label.middle_s
        self._look()
        self._show()

    def _look(self) -> None:
        """Show the time around the reach, or the cursor."""
        label, around_s = self._label, AROUND_S[self._zoom]
        if label is None or self._has_cursor:
            self._view = (self._at_s - 2 * around_s, self._at_s + 2 * around_s)
        else:
            self._view = (label.start_s - around_s, label.end_s + around_s)

    def _go(self, at_s: float) -> None:
        """Show a time, with the cursor at it, and the reach that is there."""
        correction = self._correction
        self._at_s = min(max(at_s, correction.begins_s), correction.ends_s)
        self._chosen, self._has_cursor = correction.at(self._at_s), True
        from_s, to_s = self._view
        if not from_s + CURSOR_S <= self._at_s <= to_s - CURSOR_S:
            self._look()
        self._show()

    def _show(self, told: str = "") -> None:
        """Show what is chosen, and a sentence on the last key; that nothing is saved goes before."""
        tr, chosen = self.app.tr, self._label
        if self._why_unsaved:
            told = tr("It is not saved, S tries again: {why}", why=self._why_unsaved)
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
        listed = [at for at, label in enumerate(labels) if self._is_listed(label)]
        done = sum(labels[at].state != "found" for at in listed)
        number = listed.index(self._chosen) + 1 if self._chosen in listed else "–"
        slots = {"number": number, "count": len(listed)}
        parts = [
            tr("Unsure {number} of {count}", **slots)
            if self._only_unsure
            else tr("Reach {number} of {count}", **slots),
            tr("{done} looked at", done=done),
        ]
        if self._why_unsaved:
            parts.append(tr("not saved"))
        elif self._has_saved:
            parts.append(tr("saved"))
        return " · ".join(parts)

    def _is_listed(self, label: Label) -> bool:
        return label.is_unsure or not self._only_unsure

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

    # --- keys: from reach to reach

    def action_next(self, step: int) -> None:
        """Show the next reach, or the one before."""
        index = self._correction.next(
            step, after=self._chosen, at_s=self._at_s, only_unsure=self._only_unsure
        )
        if index is not None:
            self._choose(index)
        else:
            self._show(self._told_at(step))

    def _told_at(self, step: int) -> str:
        """Return what is to be said at the end of the reaches, or at their beginning."""
        tr: Language = self.app.tr
        if step < 0:
            return tr("There is no reach before this one.")
        waiting = (label for label in self._correction.labels if label.state == "found")
        if any(map(self._is_listed, waiting)):
            return tr("There is no reach after this one.")
        if self._only_unsure:
            return tr("You have looked at all unsure reaches. U shows all again.")
        return tr("You have looked at all reaches. Esc leaves.")

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

    # --- keys: corrections

    def action_go_on(self) -> None:
        """Do what the key row says: accept a reach that was found, and show the next one."""
        label = self._label
        if label is None or label.state == "found":
            self.action_accept()
        else:
            self.action_next(1)

    def action_accept(self) -> None:
        """Confirm the reach, and show the next one. A held key confirms only one."""
        before_s, self._accepted_s = self._accepted_s, self.app.key_seconds
        if self._accepted_s - before_s < HELD_S:
            return
        if self._decided(self._correction.accept):
            self.action_next(1)

    def action_drop(self) -> None:
        """Drop the reach, or take that back."""
        if self._decided(self._correction.drop):
            self._show()

    def _decided(self, decide: Callable[[int], int | None]) -> bool:
        """Accept or drop the reach, and return True; say why if that is not possible."""
        if self._chosen is None:
            self._show(self.app.tr("There is no reach here. I adds one."))
            return False
        index = decide(self._chosen)
        if index is None:
            self._show(self.app.tr("It overlaps another reach: drop that one first."))
            return False
        self._chosen = index
        self._changed()
        return True

    def action_insert(self) -> None:
        """Add a reach at the cursor."""
        index = self._correction.insert(self._at_s)
        if index is None:
            self._show(self.app.tr("There is no room for another reach here."))
            return
        self._changed()
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
        self._at_s = label.middle_s
        if label.start_s < from_s + STEP_S or label.end_s > to_s - STEP_S:
            self._look()
        self._changed()
        self._show()

    def action_undo(self) -> None:
        """Take back the last correction, and show the reach that it was of."""
        label = self._correction.undo()
        if label is None:
            self._show(self.app.tr("There is nothing to take back."))
            return
        self._changed()
        if label in self._correction.labels:
            self._choose(self._correction.labels.index(label))
        else:
            self._go(label.middle_s)

    # --- keys: what is looked at

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

        def go(seconds: float | None) -> None:
            if seconds is not None:
                self._go(self._correction.begins_s + seconds)

        self.app.push_screen(GoToScreen(), go)

    def action_zoom(self, step: int) -> None:
        """Show a shorter or a longer time."""
        self._zoom = min(max(self._zoom + step, 0), len(AROUND_S) - 1)
        self._look()
        self._show()

    # --- saving and leaving

    def _changed(self) -> None:
        """Save what was corrected, soon."""
        if self._saving is None:
            self._saving = self.set_timer(SAVE_AFTER_S, self.save)

    def save(self) -> bool:
        """Store the labels, and return True; say why if that is not possible."""
        if self._saving is not None:
            self._saving.stop()
            self._saving = None
        tr = self.app.tr
        try:
            self._save(self._correction.labels)
        except (SourceError, OSError) as error:
            why = getattr(error, "strerror", None) or str(error)
            self._why_unsaved = why
            self._show()
            return False
        self._correction.saved()
        self._has_saved = True
        if self._why_unsaved:
            self._why_unsaved = ""
            self._show(tr("It is saved."))
        self.query_one("#where", Static).update(self._where())
        return True

    def action_save(self) -> None:
        """Store the labels at once."""
        if self.save():
            self._show(self.app.tr("It is saved."))

    def action_leave(self) -> None:
        """Leave the app; ask first if something cannot be saved."""
        if not self._correction.is_changed or self.save():
            self.app.exit()
        elif not isinstance(self.app.screen, UnsavedScreen):
            self.app.push_screen(UnsavedScreen(self._why_unsaved), self._answered)

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
            return tr("This is no reach."), on
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
