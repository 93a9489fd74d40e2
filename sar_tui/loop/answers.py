"""Answers of the session to operators' acts, each given once (see `ActAnswered`)."""

from collections.abc import Callable, Collection

import msgspec

from sar_tui.model.messages import ActAnswered, ActionPart, ActOutcome, OperatorAct, OutputReport

Part = tuple[str, ActionPart]
"""An output, and a part of an action that it carries out."""
_OVER = ("done", "aborted", "failed")


def answer_to(
    act: OperatorAct, at: int, outcome: ActOutcome = "done", why: str = ""
) -> ActAnswered:
    """Return the answer to an act that arrived ``at`` (ns)."""
    return ActAnswered(seat=act.seat, id=act.id, actor=act.actor, outcome=outcome, why=why, at=at)


class _OpenAct(msgspec.Struct):
    """An act on an action, and the parts of that action that are not over.

    Attributes:
        act: as it was received, ``at`` (ns).
        halts: the act ends the action; else it asks for it.
        parts: None until the action begins.
        failed: outputs that could not do their part.
        halted: a part was ended early.
    """

    act: OperatorAct
    at: int
    halts: bool
    parts: set[Part] | None = None
    failed: list[str] = []
    halted: bool = False

    @property
    def answer(self) -> ActAnswered:
        """The answer, once all parts are over."""
        if self.failed:
            return answer_to(
                self.act, self.at, "refused", f"An output failed: {', '.join(self.failed)}."
            )
        if self.halts and not self.halted:
            return answer_to(self.act, self.at, "late", "It was over already.")
        if self.halted and not self.halts:
            return answer_to(self.act, self.at, "refused", "It was stopped before its end.")
        return answer_to(self.act, self.at)


class OpenActs:
    """Acts that outputs must carry out: remarks until they were said, cancellations until the
    action is still.

    Args:
        publish: called with each answer.
    """

    def __init__(self, publish: Callable[[ActAnswered], None]) -> None:
        self._publish = publish
        self._open: dict[str, list[_OpenAct]] = {}

    def add_request(self, action: str, act: OperatorAct, at: int) -> None:
        """Add a request for an action, by its id, that has not begun."""
        self._add(action, _OpenAct(act, at, halts=False))

    def add_halt(self, action: str, act: OperatorAct, at: int, parts: Collection[Part]) -> None:
        """Add a cancellation of the action under way, of which ``parts`` are not over."""
        self._add(action, _OpenAct(act, at, halts=True, parts=set(parts)))

    def begin(self, action: str, parts: Collection[Part]) -> None:
        """Note that an action begins. Without any parts it is done."""
        for each in self._open.get(action, ()):
            each.parts = set(parts)
        self._answer_ended(action)

    def report(self, report: OutputReport) -> None:
        """Note a part's state. Text on a screen counts as shown at once: it stays until other text
        comes.
        """
        is_over = report.state in _OVER or (report.part == "show" and report.state == "started")
        if not is_over or report.action not in self._open:
            return
        for each in self._open[report.action]:
            if each.parts and (part := (report.output, report.part)) in each.parts:
                each.parts.remove(part)
                each.halted |= report.state == "aborted"
                if report.state == "failed":
                    each.failed.append(report.output)
        self._answer_ended(report.action)

    def give_up(self, action: str, outcome: ActOutcome, why: str) -> None:
        """Answer that an action is not carried out, or that it is not known how it ended."""
        for each in self._open.pop(action, ()):
            self._publish(answer_to(each.act, each.at, outcome, why))

    def forget(self) -> None:
        """Forget all acts: nobody waits for answers of an earlier run."""
        self._open.clear()

    def _add(self, action: str, act: _OpenAct) -> None:
        if act.act.id:
            self._open.setdefault(action, []).append(act)

    def _answer_ended(self, action: str) -> None:
        acts = self._open.pop(action, [])
        for each in acts:
            if each.parts is not None and not each.parts:
                self._publish(each.answer)
        if still_open := [each for each in acts if each.parts is None or each.parts]:
            self._open[action] = still_open
