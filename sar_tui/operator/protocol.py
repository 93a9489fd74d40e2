"""The operator's protocol on the panel: what is due, and the acts by which it is done."""

from typing import Any

from msgspec.structs import replace
from rich.cells import cell_len, set_cell_size
from textual.content import Content

from sar_tui.link.peer import PeerEvent, Welcome
from sar_tui.loop.topics import DECISION, PROTOCOL, PROTOCOL_TICKED, REMARK
from sar_tui.model.language import Language
from sar_tui.model.messages import (
    Decision,
    ProtocolChosen,
    ProtocolDue,
    ProtocolTicked,
    Remark,
)
from sar_tui.model.protocol import ProtocolStep, WizardProtocol
from sar_tui.operator.act_log import decision_wording, gesture_wording, said_wording, same
from sar_tui.operator.commands import TOO_SOON, Commands
from sar_tui.operator.keymap import KeymapFile, key_label
from sar_tui.operator.phrases import Phrase, addressed, addressee_code, phrases_of_key
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.text_charts import Piece, cut
from sar_tui.rules.protocol import unit_factor, verdict_on
from sar_tui.rules.protocol_file import Deed, deed_of

_MOMENTS = {
    "start": "at the start",
    "attempt": "in attempt {number}",
    "after attempt": "after attempt {number}",
    "pause": "in a pause",
    "end": "at the end",
}


class ProtocolActs:
    """Acts of one operator by a protocol: chooses it for the session, does what is due, ticks it.

    Args:
        commands: the operator's.
        own: the protocol that this panel was opened with; None: that of the session, if any. Also
            an attribute.
        practised: recorded sessions on which the operator has practised it.
    """

    def __init__(self, commands: Commands, own: WizardProtocol | None, practised: int) -> None:
        self._commands = commands
        self.own, self._practised = own, practised
        self._is_offered = False
        self._run_chosen_in = ""
        self._ticked_at = 0

    def receive(self, event: PeerEvent) -> None:
        """Choose the own protocol once this operator has control, unless the session follows it or
        the choice is on its way: a snapshot of the session may be older than it.
        """
        state, peer = self._commands.state, self._commands.peer
        if isinstance(event, Welcome):
            self._is_offered = False
        knows_session = isinstance(event, list) and state.arbiter is not None
        if self.own is None or self._is_offered or not knows_session or peer is None:
            return
        if not state.has_control or not state.is_connected or state.ended or self._is_on_its_way:
            return
        self._is_offered = True
        if state.protocol is None or state.protocol.hash != self.own.hash:
            self._choose(self.own, peer.now())

    @property
    def _is_on_its_way(self) -> bool:
        """True while this run of the session has not answered the choice; after a lost connection,
        it still may.
        """
        commands = self._commands
        acts = [act for act in commands.log.acts if isinstance(act.message, ProtocolChosen)]
        welcome = commands.state.welcome
        is_this_run = welcome is not None and welcome.run == self._run_chosen_in
        return is_this_run and bool(acts) and acts[-1].answer is None

    def _choose(self, protocol: WizardProtocol, now: int) -> None:
        commands, tr = self._commands, self._commands.tr
        unit = commands.state.welcome.unit if commands.state.welcome else ""
        for rule in protocol.rules:
            if unit_factor(unit, rule.when.unit) is None:
                text = tr(
                    "The protocol is not used: results are in {unit}, and a rule says “{rule}”."
                )
                commands.log.report(now, text.format(unit=unit, rule=rule.text))
                return
        wording = same(tr("Protocol: {name}").format(name=title(protocol)))
        chosen = ProtocolChosen(protocol=protocol, practised=self._practised)
        self._run_chosen_in = commands.state.welcome.run if commands.state.welcome else ""
        commands.send(wording, PROTOCOL, chosen, now)

    # --- what is due

    def tick(self, seat: str, at: int) -> bool:
        """Do what is due, as far as the panel can, and tick it.

        Args:
            seat: the participant whom a step is for; a rule is for the one whose result it is.
            at: time stamp of the key (ns).
        """
        if (due := self._due(at)) is None:
            return False
        act = self._do(due, seat if due.what == "step" else due.seat, at)
        return act is not None and self._tick(due, "done", at, act)

    def leave_out(self, at: int) -> bool:
        """Tick what is due as not done."""
        due = self._due(at)
        return due is not None and self._tick(due, "not done", at)

    def _due(self, at: int) -> ProtocolDue | None:
        """Return what is due first, unless its tick is on its way; None, and a line of the log, if
        nothing is, or nobody can have read it yet.
        """
        commands, tr = self._commands, self._commands.tr
        due = next(iter(commands.state.due), None)
        if due is None:
            commands.log.report(at, tr("Nothing is due by a protocol."))
            return None
        if commands.log.last_open(
            lambda act: isinstance(act, ProtocolTicked) and act.due == due.id
        ):
            return None
        if at - max(due.at, self._ticked_at) < TOO_SOON:
            commands.log.report(at, tr("Too soon: that had only just become due."))
            return None
        return due

    def _tick(self, due: ProtocolDue, outcome: Any, at: int, act: str = "") -> bool:
        text = self._commands.tr("Done: {what}" if outcome == "done" else "Not done: {what}")
        self._ticked_at = at
        ticked = ProtocolTicked(seat=due.seat, due=due.id, outcome=outcome, act=act)
        return self._commands.send(same(text.format(what=due.do)), PROTOCOL_TICKED, ticked, at)

    def _do(self, due: ProtocolDue, seat: str, at: int) -> str | None:
        """Do what is due and return the id of the act; empty if it is for the operator alone, None
        if it was not sent.
        """
        commands, state = self._commands, self._commands.state
        protocol = state.protocol
        if protocol is None:
            return None
        deed = deed_of(due.do, protocol)
        match deed.verb:
            case "say" | "key" | "phrase":
                is_sent = self._say(deed, due, seat, at)
            case "gesture" if state.theme and deed.text not in state.theme.gestures:
                text = commands.tr("The theme has no gesture {text!r}.").format(text=deed.text)
                commands.log.report(at, text)
                return None
            case "gesture":
                remark = Remark(gesture=deed.text, source="gesture", seat=seat)
                wording = gesture_wording(deed.text, commands.tr)
                is_sent = commands.send(wording, REMARK, remark, at)
            case "level by":
                is_sent = commands.level(deed.number, at)
            case "level":
                is_sent = commands.set_level(deed.number, at)
            case "veto" | "approve":
                if (decision := self._decision(due, protocol)) is None:
                    return ""  # it was decided by its own key
                wording = decision_wording(decision, str(deed.kind), commands.tr)
                is_sent = commands.send(wording, DECISION, decision, at)
            case _:
                return ""
        return commands.log.acts[-1].message.id if is_sent else None

    def _say(self, deed: Deed, due: ProtocolDue, seat: str, at: int) -> bool:
        commands, state = self._commands, self._commands.state
        if (phrase := _phrase(deed, due, state)) is None:
            text = commands.tr("The theme has no phrase {text!r}.").format(text=deed.text)
            commands.log.report(at, text)
            return False
        if not (filled := commands.fill(phrase.text, seat, at)):
            return False
        remark = replace(phrase.remark(addressed(state, seat, filled)), seat=seat)
        wording = said_wording(filled, addressee_code(state, seat), commands.tr)
        return commands.send(wording, REMARK, remark, at)

    def _decision(self, due: ProtocolDue, protocol: WizardProtocol) -> Decision | None:
        """Return the decision on the first pending proposal that is meant; None if none is."""
        for each in self._commands.pending:
            if verdict := verdict_on(each.proposal, due, protocol):
                return Decision(action=each.proposal.id, verdict=verdict, seat=each.proposal.seat)
        return None


def _phrase(deed: Deed, due: ProtocolDue, state: SessionState) -> Phrase | None:
    """Return what is to be said; of a theme's phrases with a key the next one from attempt to
    attempt.
    """
    if deed.verb == "key":
        phrases = phrases_of_key(state.theme, deed.text) if state.theme else []
        return phrases[due.attempt % len(phrases)] if phrases else None
    if deed.verb == "phrase":
        return Phrase(state.protocol.phrases[deed.number - 1]) if state.protocol else None
    return Phrase(deed.text)


# --- drawing


def title(protocol: WizardProtocol) -> str:
    """Return a protocol's name and version."""
    return f"{protocol.name} {protocol.version}"


def protocol_line(state: SessionState, file: KeymapFile, width: int) -> Content:
    """Return what is due and the keys that tick it; else the next step."""
    tr, protocol = state.tr, state.protocol
    if protocol is None:
        return Content("")
    if not state.due:
        following = next_step(state)
        if following is None:
            text = tr("Protocol {name}: no step is to come.").format(name=title(protocol))
        else:
            text = tr("Next, {moment}: {what}").format(
                moment=moment_text(following, tr), what=_what(following.do, protocol)
            )
        return Content.assemble((cut(text, width), "$text-muted"))
    due = state.due[0]
    keys: list[Piece] = [
        (f" {key_label('tick', file, tr)}", "$accent bold"),
        (f" {tr('tick')}", ""),
        (f" {key_label('leave-out', file, tr)}", "$accent bold"),
        (f" {tr('leave out')}", ""),
    ]
    more = f" +{len(state.due) - 1}" if len(state.due) > 1 else ""
    room = width - sum(cell_len(text) for text, _ in keys) - len(more)
    text = cut(f"▶ {_what(due.do, protocol)} ({_why(due, protocol, tr)})", room)
    return Content.assemble((text, "$warning bold"), (more, "$text-muted"), *keys)


def _what(do: str, protocol: WizardProtocol) -> str:
    """Return what is to be done as it is written, with the words of the protocol's own phrases."""
    deed = deed_of(do, protocol)
    return f"say “{protocol.phrases[deed.number - 1]}”" if deed.verb == "phrase" else do


def _why(due: ProtocolDue, protocol: WizardProtocol, tr: Language) -> str:
    if due.what == "rule":
        return protocol.rules[due.number - 1].text
    return moment_text(protocol.steps[due.number - 1], tr)


def moment_text(step: ProtocolStep, tr: Language) -> str:
    """Return the moment of a step in words."""
    return tr(_MOMENTS[step.at], number=step.attempt)


def next_step(state: SessionState) -> ProtocolStep | None:
    """Return the first step that is to come, apart from those of pauses."""
    attempt = state.waiting.attempt if state.waiting else 0
    for number, step in enumerate(state.protocol.steps if state.protocol else (), 1):
        is_over = step.at in ("attempt", "after attempt") and step.attempt < attempt
        if step.at not in ("start", "pause") and number not in state.past_steps and not is_over:
            return step
    return None


def reasons_page(protocol: WizardProtocol, width: int, rows: int, tr: Language) -> Content:
    """Return the reasons for a veto or an edit with their digits, in two columns."""
    column = width // 2 - 1
    cells = [(str(each.code), tr(each.text)) for each in protocol.reasons]
    parts: list[Piece] = []
    for row in range(min(rows, len(cells))):
        for code, text in cells[row::rows]:
            shown = set_cell_size(cut(text, column - 3), column - 2)
            parts += [(f"{code} ", "$accent bold"), (f"{shown} ", "")]
        parts.append(("\n", ""))
    return Content.assemble(*parts[:-1])
