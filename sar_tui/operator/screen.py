"""The operator's panel: what its keys do."""

from collections.abc import Callable
from typing import Any, ClassVar

from textual import events
from textual.binding import BindingType

from sar_tui.framework.clock import SECOND, host_now
from sar_tui.framework.messages import PendingApproval, Valence
from sar_tui.operator import palette
from sar_tui.operator.commands import CONFIRM_SECONDS, editable, takes_valence
from sar_tui.operator.keymap import KEY_COMMANDS, bindings
from sar_tui.operator.layout import PanelLayout
from sar_tui.operator.phrases import LONGEST, addressee
from sar_tui.operator.proposal_strip import ProposalStrip

_ACTIONS = {key_command.action.partition("(")[0] for key_command in KEY_COMMANDS}
_FOR_ALL = {key_command.action.partition("(")[0] for key_command in KEY_COMMANDS if not key_command.acts}
_WHILE_TYPING = ("stop", "leave", "keys", "event")
_WHILE_COVERED = ("stop", "leave", "keys")
"""What keys do while something lies over the panel: nobody steers what they do not see."""
_LONGEST_NOTE = 4000


class PanelScreen(PanelLayout):
    """What an operator, or an observer, sees of a session; and what an operator does."""

    BINDINGS: ClassVar[list[BindingType]] = [*bindings()]

    def __init__(self, *made: Any, **how: Any) -> None:
        super().__init__(*made, **how)
        self._typing: Callable[[str, int], bool] | None = None

    # --- proposals -----------------------------------------------------------------------------------------------

    @property
    def _at(self) -> int:
        """When the key that is handled now was pressed, on the session's clock."""
        peer = self.commands.peer
        assert peer
        pressed = round(self.app.key_seconds * SECOND)
        return peer.now() - (max(0, host_now() - pressed) if pressed else 0)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """An observer's keys do not act; and while something is typed, keys are letters."""
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
            self._done(self.commands.decide(approval, "accept", self._at))

    def action_veto(self) -> None:
        if approval := self.chosen:
            self._done(self.commands.decide(approval, "veto", self._at))

    def action_valence(self, valence: Valence) -> None:
        if (approval := self.chosen) and takes_valence(approval):
            self._done(self.commands.change_valence(approval, valence, self._at))

    def action_select(self, step: int) -> None:
        waiting = self.commands.pending
        if approval := self.chosen:
            self.selected = waiting[(waiting.index(approval) + step) % len(waiting)].proposal.id
            self.draw()

    def action_edit(self) -> None:
        """Without a proposal, perhaps because it has just gone, what is typed must not be taken for keys."""
        if approval := self.chosen:
            self.selected = approval.proposal.id
            text = editable(approval, self.commands.state)
            self._type("Instead:", text, lambda text, at: self._edited(approval, text, at), edits=approval)
        else:
            self.commands.log.report(self._at, "No proposal waits: what you type is said as your own words.")
            self.action_say()

    def _edited(self, approval: PendingApproval, text: str, at: int) -> bool:
        if any(each.proposal.id == approval.proposal.id for each in self.commands.pending):
            return self.commands.edit(approval, text, at)
        self.commands.log.report(at, "Too late: it was decided. Nothing was sent; Enter says it all the same.")
        if approval.level is None and approval.proposal.text:
            self._type("Say:", text, lambda words, when: self.commands.say(words, approval.proposal.seat, when))
            return False
        return True

    # --- the session ---------------------------------------------------------------------------------------------

    def action_stop(self) -> None:
        self._done(self.commands.command("Stopped", "stop", self._at))

    def action_pause(self) -> None:
        if self.commands.may_resume(self._at):
            self.question = ""
            self._done(self.commands.pause(self._at))
        else:
            self.ask_for(CONFIRM_SECONDS, "resume")

    def action_skip(self) -> None:
        self._done(self.commands.prompt_command("Skipped the prompt", "skip", self._at))

    def action_repeat(self) -> None:
        self._done(self.commands.prompt_command("Repeated the prompt", "repeat", self._at))

    def action_level(self, step: int) -> None:
        self._done(self.commands.level(step, self._at))

    def action_hold(self) -> None:
        self._done(self.commands.hold(self._at))

    def action_end(self) -> None:
        if self._ask("end"):
            self._done(self.commands.command("Ended the session", "end", self._at))

    def action_close(self) -> None:
        if self.is_over or self._ask("close"):
            self.dismiss("")

    def _ask(self, what: str) -> bool:
        """Whether it was asked already; now it is."""
        was_asked, self.question = self.question == what, "" if self.question == what else what
        self.draw()
        return was_asked

    # --- the palette, words, notes --------------------------------------------------------------------------------

    def action_pick(self, index: int) -> None:
        items = self.find_page()[0].items
        if index < len(items):
            self._done(self.commands.pick(items[index], self._at))

    def action_page(self, step: int) -> None:
        pages = palette.pages(self.commands.state, self.phrase_book, self.seat)
        page = pages[(self.find_page()[1] + step) % len(pages)]
        self.page = (page.kind, page.title)
        self.draw()

    def action_show(self, kind: str) -> None:
        page = next(p for p in palette.pages(self.commands.state, self.phrase_book, self.seat) if p.kind == kind)
        self.page = (page.kind, page.title)
        self.draw()

    def action_seat(self) -> None:
        welcome = self.commands.state.welcome
        if names := sorted(welcome.participants if welcome else ()):
            self.seat = names[(names.index(self.seat) + 1) % len(names)] if self.seat in names else names[0]
            self.draw()

    def action_say(self) -> None:
        seat = self.seat
        to = addressee(self.commands.state, seat)
        self._type(f"Say{to}:", "", lambda text, at: self.commands.say(text, seat, at))

    def action_note(self) -> None:
        begun = self._at
        self._type("Note:", "", lambda text, at: self.commands.note(text, begun), most=_LONGEST_NOTE)

    def action_event(self, index: int) -> None:
        if index < len(self.file.events):
            self._done(self.commands.event(self.file.events[index], self._at))

    def action_baton(self) -> None:
        if self.commands.peer and self.commands.state.is_connected:
            self.commands.peer.take_control()

    def action_keys(self) -> None:
        keys = self.query_one("#key-help")
        keys.display = not keys.display

    def action_leave(self) -> None:
        """What is open is closed, one at a time: what is typed, the keys, a question, a page."""
        keys = self.query_one("#key-help")
        if self._typing:
            self._stop_typing()
        elif keys.display:
            keys.display = False
        elif self.question:
            self.question = ""
        else:
            self.page = ("", "")
        self.draw()

    def _done(self, sent: bool) -> None:
        """A key was heeded, or why not stands in the log."""
        self.is_stale = True
        self.draw()

    # --- typing ------------------------------------------------------------------------------------------------

    def takes(self, event: events.Key | events.Paste) -> bool:
        if not self._typing or self.is_covered:
            return False
        typed = self.query_one(ProposalStrip).entry
        if isinstance(event, events.Paste):
            typed.put(next(iter(event.text.splitlines()), ""))
        elif event.key == "enter":
            self._typed(typed.value.strip())
        elif event.is_printable and event.character:
            typed.put(event.character)
        else:
            return False
        self.is_stale = True
        return True

    def _type(
        self,
        asked: str,
        text: str,
        then: Callable[[str, int], bool],
        most: int = LONGEST,
        edits: PendingApproval | None = None,
    ) -> None:
        """Have something typed; ``then`` is given it, with the stamp of Enter, and says whether that is done."""
        if refusal := self.commands.refusal():
            self.commands.log.report(self._at, f"{refusal} Nothing can be sent.")
            self.draw()
            return
        self._typing, self.edited, self.entry_label = then, edits, asked
        self.query_one(ProposalStrip).add_class("typing")
        typed = self.query_one(ProposalStrip).entry
        typed.max_length, typed.value = most, text
        typed.cursor_position = len(text)
        self.set_focus(typed)  # at once: the next key may have been read already
        self.draw()

    def _stop_typing(self) -> None:
        self._typing, self.edited, self.entry_label = None, None, ""
        self.query_one(ProposalStrip).remove_class("typing")
        self.set_focus(None)

    def _typed(self, text: str) -> None:
        then = self._typing
        if then and text and then(text, self._at):
            self._stop_typing()
        self.draw()
