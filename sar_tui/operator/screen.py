"""Screen of the operator's panel: its keys."""

from collections.abc import Callable
from typing import Any, ClassVar

from textual import events
from textual.binding import BindingType

from sar_tui.loop.clock import host_now
from sar_tui.loop.topics import DECISION, NOTE_ADDED, REMARK
from sar_tui.model.messages import PendingApproval, Valence
from sar_tui.model.units import SECOND
from sar_tui.operator import palette
from sar_tui.operator.commands import CONFIRM_SECONDS, editable, takes_valence
from sar_tui.operator.keymap import KEY_COMMANDS, bindings
from sar_tui.operator.layout import PanelLayout
from sar_tui.operator.phrases import MAX_TEXT, addressee
from sar_tui.operator.proposal_strip import ProposalStrip

_ACTIONS = {command.action.partition("(")[0] for command in KEY_COMMANDS}
_FOR_ALL = {command.action.partition("(")[0] for command in KEY_COMMANDS if not command.acts}
_WHILE_TYPING = ("stop", "leave", "keys", "event")
_WHILE_COVERED = ("stop", "leave", "keys")
"""Actions that work while something hides the panel: nobody should act on what they cannot see."""
_MAX_NOTE = 4000


class PanelScreen(PanelLayout):
    """Panel of an operator or an observer."""

    BINDINGS: ClassVar[list[BindingType]] = [*bindings()]

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._typing: Callable[[str, int], bool] | None = None

    # --- proposals

    @property
    def _at(self) -> int:
        """Time stamp of the key that is being handled (ns, session clock)."""
        peer = self.commands.peer
        assert peer
        pressed = round(self.app.key_seconds * SECOND)
        return peer.now() - (max(0, host_now() - pressed) if pressed else 0)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Disable an observer's acts, and most keys while text is typed or the panel is hidden."""
        welcome = self.commands.state.welcome
        if welcome and welcome.role == "observer" and action in _ACTIONS and action not in _FOR_ALL:
            return False
        if action not in _ACTIONS:
            return True
        if self.is_covered:
            return action in _WHILE_COVERED
        return action in _WHILE_TYPING if self._typing else True

    def action_approve(self) -> None:
        if approval := self.chosen:
            self._show_result(self.commands.decide(approval, "accept", self._at))

    def action_veto(self) -> None:
        if approval := self.chosen:
            self._show_result(self.commands.decide(approval, "veto", self._at))

    def action_valence(self, valence: Valence) -> None:
        if (approval := self.chosen) and takes_valence(approval):
            self._show_result(self.commands.change_valence(approval, valence, self._at))

    def action_select(self, step: int) -> None:
        waiting = self.commands.pending
        if approval := self.chosen:
            self.selected = waiting[(waiting.index(approval) + step) % len(waiting)].proposal.id
            self.draw()

    def action_edit(self) -> None:
        """Edit the proposal. If it has just gone, let the operator type anyway, so that letters do
        not act as keys.
        """
        if approval := self.chosen:
            self.selected = approval.proposal.id
            unused = self.commands.log.unused_text(DECISION, approval.proposal.id)
            text = unused or editable(approval, self.commands.state)
            self._open_entry(
                "Edit:", text, lambda text, at: self._edited(approval, text, at), edited=approval
            )
        else:
            self.commands.log.report(
                self._at, "No proposal is pending: the agent will say what you type."
            )
            self.action_say()

    def _edited(self, approval: PendingApproval, text: str, at: int) -> bool:
        if any(each.proposal.id == approval.proposal.id for each in self.commands.pending):
            return self.commands.edit(approval, text, at)
        has_words = approval.level is None and approval.proposal.text
        what = "Nothing was sent; Enter says it anyway." if has_words else "Nothing was sent."
        self.commands.log.report(at, f"Too late: it was already decided. {what}")
        if has_words:
            self._open_entry(
                "Say:", text, lambda text, at: self.commands.say(text, approval.proposal.seat, at)
            )
        return not has_words

    # --- the session

    def action_stop(self) -> None:
        self._show_result(self.commands.command("Stopped", "stop", self._at))

    def action_pause(self) -> None:
        if self.commands.may_resume(self._at):
            self.question = ""
            self._show_result(self.commands.pause(self._at))
        else:
            self.ask_for(CONFIRM_SECONDS, "resume")

    def action_skip(self) -> None:
        self._show_result(self.commands.prompt_command("Skipped the prompt", "skip", self._at))

    def action_repeat(self) -> None:
        self._show_result(self.commands.prompt_command("Repeated the prompt", "repeat", self._at))

    def action_level(self, step: int) -> None:
        self._show_result(self.commands.level(step, self._at))

    def action_hold(self) -> None:
        self._show_result(self.commands.hold(self._at))

    def action_end(self) -> None:
        if self._confirm("end"):
            self._show_result(self.commands.command("Ended the session", "end", self._at))

    def action_close(self) -> None:
        if self.may_quit():
            self.dismiss("")

    def may_quit(self) -> bool:
        """Return True if the panel may be left; else ask."""
        return self.is_over or self.is_covered or self._confirm("close")

    def _confirm(self, question: str) -> bool:
        """Ask a question, or return True if it was asked already."""
        was_asked, self.question = (
            self.question == question,
            "" if self.question == question else question,
        )
        self.draw()
        return was_asked

    # --- palette, speech, notes

    def action_pick(self, index: int) -> None:
        items = self.find_page()[0].items
        if index < len(items):
            self._show_result(self.commands.pick(items[index], self._at))

    def action_page(self, step: int) -> None:
        pages = palette.pages(self.commands.state, self.phrase_book, self.seat)
        page = pages[(self.find_page()[1] + step) % len(pages)]
        self.page = (page.kind, page.title)
        self.draw()

    def action_show(self, kind: str) -> None:
        page = next(
            p
            for p in palette.pages(self.commands.state, self.phrase_book, self.seat)
            if p.kind == kind
        )
        self.page = (page.kind, page.title)
        self.draw()

    def action_seat(self) -> None:
        welcome = self.commands.state.welcome
        if names := sorted(welcome.participants if welcome else ()):
            self.seat = (
                names[(names.index(self.seat) + 1) % len(names)] if self.seat in names else names[0]
            )
            self.draw()

    def action_say(self) -> None:
        seat = self.seat
        to = addressee(self.commands.state, seat)
        unused = self.commands.log.unused_text(REMARK)
        self._open_entry(f"Say{to}:", unused, lambda text, at: self.commands.say(text, seat, at))

    def action_note(self) -> None:
        began = self._at
        unused = self.commands.log.unused_text(NOTE_ADDED)
        self._open_entry(
            "Note:", unused, lambda text, at: self.commands.note(text, began), max_length=_MAX_NOTE
        )

    def action_event(self, index: int) -> None:
        if index < len(self.file.events):
            self._show_result(self.commands.event(self.file.events[index], self._at))

    def action_take_control(self) -> None:
        if self.commands.peer and self.commands.state.is_connected:
            self.commands.peer.take_control()

    def action_keys(self) -> None:
        keys = self.query_one("#key-help")
        keys.display = not keys.display

    def action_leave(self) -> None:
        """Close one thing: the text field, the key help, the question, or the palette's page."""
        keys = self.query_one("#key-help")
        if self._typing:
            self._close_entry()
        elif keys.display:
            keys.display = False
        elif self.question:
            self.question = ""
        else:
            self.page = ("", "")
        self.draw()

    def _show_result(self, _: bool) -> None:
        """Draw the act of a key, or the log line that says why none was sent."""
        self.is_stale = True
        self.draw()

    # --- typing

    def takes(self, event: events.Key | events.Paste) -> bool:
        if not self._typing or self.is_covered:
            return False
        typed = self.query_one(ProposalStrip).entry
        if isinstance(event, events.Paste):
            typed.put(next(iter(event.text.splitlines()), ""))
        elif event.key == "enter":
            self._submit(typed.value.strip())
        elif event.is_printable and event.character:
            typed.put(event.character)
        else:
            return False
        self.is_stale = True
        return True

    def _open_entry(
        self,
        label: str,
        text: str,
        then: Callable[[str, int], bool],
        max_length: int = MAX_TEXT,
        edited: PendingApproval | None = None,
    ) -> None:
        """Open the text field.

        Args:
            label: text in front of it.
            text: initial content.
            then: called with the text and the time stamp of Enter; returns True if the field can be
                closed.
            max_length: longest text, in characters.
            edited: the proposal that is edited.
        """
        if reason := self.commands.refusal():
            self.commands.log.report(self._at, f"{reason} Nothing can be sent.")
            self.draw()
            return
        self._typing, self.edited, self.entry_label = then, edited, label
        self.query_one(ProposalStrip).add_class("typing")
        typed = self.query_one(ProposalStrip).entry
        typed.max_length, typed.value = max_length, text
        typed.cursor_position = len(text)
        self.set_focus(typed)  # now, because the next key may have been read already
        self.draw()

    def _close_entry(self) -> None:
        self._typing, self.edited, self.entry_label = None, None, ""
        self.query_one(ProposalStrip).remove_class("typing")
        self.set_focus(None)

    def _submit(self, text: str) -> None:
        then = self._typing
        if then and text and then(text, self._at):
            self._close_entry()
        self.draw()
