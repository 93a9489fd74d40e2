"""Strip of the panel with the proposal to decide on, or the text that the operator types."""

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content, Span

from sar_tui.model.messages import PendingApproval
from sar_tui.operator import key_help, proposal_view
from sar_tui.operator.act_log import doing
from sar_tui.operator.commands import Commands, takes_valence
from sar_tui.operator.keymap import KeymapFile
from sar_tui.operator.phrases import addressee
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.text_charts import cut
from sar_tui.operator.widgets import CachedStatic, TypedInput


class ProposalStrip(Vertical):
    """One proposal with its time and keys; the others; and, while something is typed, the text
    field.

    Args:
        file: the operator's keys.
    """

    def __init__(self, file: KeymapFile) -> None:
        super().__init__()
        self._file = file
        self._is_tall = False
        self._label = ""
        self._time_given: dict[str, int] = {}
        self._titles = ("", "")

    def compose(self) -> ComposeResult:
        yield CachedStatic("proposal")
        yield CachedStatic("decision-keys")
        with Horizontal(id="entry"):
            yield CachedStatic("entry-label", fits_content=True)
            yield TypedInput(id="entry-text", compact=True, select_on_focus=False)
        yield CachedStatic("others")

    @property
    def entry(self) -> TypedInput:
        """The text field."""
        return self.query_one(TypedInput)

    @property
    def overflows(self) -> bool:
        """True if the typed text is longer than the text field."""
        return len(self.entry.value) >= self.entry.content_size.width

    @property
    def _width(self) -> int:
        return self.query_one("#proposal").content_size.width

    def configure(self, label: str, *, is_pending: bool, is_alarm: bool, is_tall: bool) -> None:
        """Set what all drawings share.

        Args:
            label: text in front of the text field; empty while nothing is typed.
            is_pending: a proposal waits.
            is_alarm: the link is down.
            is_tall: the window has a line for the other proposals.
        """
        self.set_class(is_pending, "pending")
        self.set_class(is_alarm, "alarm")
        self._label, self._is_tall = label, is_tall

    def draw_empty(self, state: SessionState, loss: str, now: int) -> None:
        """Draw why nothing waits. ``loss``: the notice while the link is down."""
        leave_key = key_help.key_label("close", self._file)
        self._put(
            "proposal", proposal_view.nothing_pending(state, loss, now, self._width, leave_key)
        )
        self._put("decision-keys", Content(""))
        self._put("entry-label", Content(self._label))
        self._put("others", Content(""))
        self._frame("Connection" if loss else "Proposals", self._subtitle(state))

    def draw_proposal(self, approval: PendingApproval, commands: Commands, now: int) -> None:
        """Draw a proposal that waits."""
        state, pending, width, id = (
            commands.state,
            commands.pending,
            self._width,
            approval.proposal.id,
        )
        self._time_given = {
            each.proposal.id: self._time_given.get(each.proposal.id, each.deadline - now)
            for each in pending
            if each.deadline is not None
        }
        self._put("proposal", proposal_view.body(approval, now, self._time_given.get(id), width))
        keys = proposal_view.decision_keys(self._file, has_words=takes_valence(approval))
        keys = proposal_view.control_hint(state, self._file) if commands.refusal() else keys
        sent = commands.log.deciding(id)
        self._put("decision-keys", Content(f"{doing(sent)} …") if sent else keys)
        self._put("entry-label", Content(self._label))
        others = proposal_view.other_proposals(pending, approval, now, width)
        self._put("others", Content(others))
        to = addressee(state, approval.proposal.seat) if approval.level is None else ""
        title = proposal_view.title(approval, pending.index(approval) + 1, len(pending), to)
        self._frame(title, self._subtitle(state, "" if self._label else others))

    def draw_expired_edit(self, edited: PendingApproval, commands: Commands, now: int) -> None:
        """Draw the proposal that is being edited although it no longer waits: the text is not meant
        for the next.
        """
        is_late = edited.deadline is not None and edited.deadline <= now
        why = "Time is up" if is_late else "No longer pending"
        others = proposal_view.other_proposals(commands.pending, None, now, self._width)
        self._put("proposal", proposal_view.expired_edit(edited, self._width))
        self._put("entry-label", Content(f"{why}:", [Span(0, len(why) + 1, "$warning bold")]))
        self._put("others", Content(others))
        self._frame(
            f"{edited.proposal.kind.upper()} · {why.lower()}",
            self._subtitle(commands.state, others),
        )

    def _subtitle(self, state: SessionState, others: str = "") -> str:
        """Return the other proposals if they have no line of their own, else how to send typed
        text, else the modes.
        """
        if others and not self._is_tall:
            return cut(others, self._width - 4)
        return (
            "Enter sends, Esc cancels"
            if self._label
            else proposal_view.mode_summary(state, self._width - 4)
        )

    def _frame(self, title: str, subtitle: str) -> None:
        """Set the border's texts; as `Content`, because they may hold brackets."""
        if self._titles != (title, subtitle):
            self._titles = title, subtitle
            self.border_title, self.border_subtitle = Content(title), Content(subtitle)

    def _put(self, name: str, content: Content) -> None:
        self.query_one(f"#{name}", CachedStatic).show(content)
