"""The mirror in words: what stands in the head of the panel, and beside the agent."""

from textual.content import Content

from sar_tui.operator import text_charts
from sar_tui.operator.event_log import UNWELL, Line, participant, short
from sar_tui.operator.phrases import figure
from sar_tui.operator.session_state import PARTICIPANT, Seat, SessionState
from sar_tui.operator.text_charts import Piece, cut

UNKNOWN = "not known yet"
_LABEL = 8
"""Characters of a participant's code, beside their responses."""
_WAITS = {
    "enter": "Waits for Enter",
    "start": "Waits for the start key",
    "agent": "Waits until the agent is still",
    "answer": "Waits to give the answer",
    "quiet": "Waits until no key is pressed",
    "foreperiod": "A prompt comes at once",
    "storage": "Waits for the disk",
    "response": "Waits for a response",
    "resume": "Paused",
    "sensor": "Waits for the motion sensor",
    "nothing": "Waits for nothing",
}
_STAGES = {"instructions": "instructions", "review": "all done"}
_REASONS = {
    **UNWELL,
    "interrupted": "interrupted",
    "storage": "the disk",
    "held": "a key is held",
}
_SIGNS = {"plain": ("·", "$text-muted"), "good": ("✓", "$success"), "bad": ("!", "$warning bold")}


def where(mirror: SessionState) -> str:
    """The task, who does it, and how far the session has come."""
    welcome, waiting = mirror.welcome, mirror.waiting
    if welcome is None:
        return "Operator"
    parts = [welcome.title, " and ".join(welcome.participants.values())]
    if mirror.ended:
        parts.append(f"session {mirror.ended}")
    elif waiting and waiting.attempt:
        parts.append(_attempt_name(mirror, waiting.attempt))
    if mirror.level is not None:
        follows = f", then {mirror.next_level}" if mirror.next_level not in (None, mirror.level) else ""
        parts.append(f"level {mirror.level}{follows}")
    return " · ".join(part for part in parts if part)


def _attempt_name(mirror: SessionState, attempt: int) -> str:
    """The attempt as the participant's screen counts: while the answer is awaited, still the one that was done."""
    welcome, waiting = mirror.welcome, mirror.waiting
    done = [seat.attempt.attempt for seat in mirror.seats.values() if seat.attempt]
    if waiting and waiting.stage in ("answer", "review") and done:
        attempt = max(done)
    practice = int(welcome.parameters.get("practice_attempts", 0)) if welcome else 0
    total = welcome.attempts if welcome else 0
    if attempt <= practice:
        return f"practice {attempt} of {practice}"
    return f"attempt {attempt - practice} of {total - practice}"


def link(mirror: SessionState, baton_key: str = "b") -> Content:
    """How the link is, and who is at it; to an operator who does not steer, with which key they would."""
    state = mirror.connection.state
    if mirror.ended:
        return Content.assemble(("session over", "$text-muted"))
    if state != "connected":
        words = {"connecting": "connecting", "lost": "connection lost", "away": "no connection"}[state]
        return Content.assemble((f"○ {words}", "$warning bold"))
    me = mirror.welcome.name if mirror.welcome else ""
    others = [name for name in mirror.peers if name not in (me, mirror.holder)]
    watchers = [short(name) for name in others if mirror.peers[name] == "observer"]
    parts: list[Piece] = [("● ", "$success")]
    if mirror.welcome and mirror.welcome.role == "observer":
        parts.append(("you watch", "bold"))
        parts.append((f" · {short(mirror.holder)} steers", "$text-muted") if mirror.holder else ("", ""))
    elif mirror.holder == me and me:
        parts.append(("you steer", "$success bold"))
    elif mirror.holder:
        parts.append((f"{short(mirror.holder)} steers", "$warning bold"))
        parts.append((f" · {baton_key} takes the baton", "$text-muted"))
    elif not mirror.peers:
        parts.append(("connected", "$success"))
    else:
        parts.append(("nobody steers", "$warning bold"))
        parts.append((f" · {baton_key} takes the baton", "$text-muted"))
    parts.extend((f" · {short(name)}", "$text-muted") for name in others if mirror.peers[name] == "operator")
    if watchers:
        watch = f"{watchers[0]} watches" if len(watchers) == 1 else f"{len(watchers)} watch"
        parts.append((f" · {watch}", "$text-muted"))
    return Content.assemble(*parts)


def loss(mirror: SessionState) -> str:
    """What an operator has to know while the link is down; empty while it is up."""
    connection, parameters = mirror.connection, mirror.welcome.parameters if mirror.welcome else {}
    why = f" ({connection.why.rstrip('.')})" if connection.why else ""
    if mirror.ended:
        return ""
    if connection.state == "away":
        return f"The link is closed{why}. This panel shows what was known last."
    if connection.state == "connecting" and connection.why:
        return f"There is no connection yet: {connection.why}"
    if connection.state != "lost":
        return ""
    alone = {"autonomous": "by itself (autonomous)", "silent": "by itself, and says nothing that needs an operator"}
    goes = alone.get(str(parameters.get("operator_lost")), "by itself")
    return f"Connection lost{why}. If it runs, the session goes on {goes}. Trying to get back."


# --- what the participant does ----------------------------------------------------------------------------------


def doing(mirror: SessionState, width: int) -> Content:
    """What the session waits for, what stands before the participant, how they do, what the agent does."""
    if mirror.welcome is None:
        return Content.assemble((UNKNOWN.capitalize(), "$text-muted"))
    seats = sorted({*mirror.welcome.participants, *mirror.seats}) or ["A"]
    style = "$warning bold reverse" if mirror.is_their_pause else "bold"
    rows: list[list[Piece]] = [[(cut(waits(mirror), width), style)], _prompt(mirror, width)]
    for name in seats:
        label = f"{cut(mirror.welcome.participants.get(name, name), _LABEL)} " if len(seats) > 1 else ""
        rows += _seat(mirror, mirror.seat(name), label, width, is_short=len(seats) > 1)
    rows.append(_agent(mirror, width))
    return Content.assemble(*[piece for row in rows for piece in (*row, ("\n", ""))][:-1])


def waits(mirror: SessionState) -> str:
    """What the session waits for; of a pause, who made it, and why."""
    waiting = mirror.waiting
    if mirror.ended:
        return f"The session is over ({mirror.ended})"
    if waiting is None:
        return f"The session: {UNKNOWN}"
    words = _WAITS[waiting.what]
    if mirror.is_paused and waiting.reason in ("", *UNWELL) and mirror.pauser and mirror.welcome:
        theirs = mirror.pauser == PARTICIPANT
        words = f"{participant(mirror.welcome) if theirs else short(mirror.pauser)} paused"
    if reason := _REASONS.get(waiting.reason):
        words += f": {reason}"
    if waiting.stage == "trial":
        return f"{words} · {waiting.trial} of {waiting.trials}"
    return f"{words} · {stage}" if (stage := _STAGES.get(waiting.stage)) else words


def _prompt(mirror: SessionState, width: int) -> list[Piece]:
    if mirror.prompt is None:
        return [("No prompt is up", "$text-muted")]
    return [("Prompt  ", "$text-muted"), (cut(mirror.prompt.text, width - 8), "$accent bold")]


def _seat(mirror: SessionState, seat: Seat, label: str, width: int, *, is_short: bool) -> list[list[Piece]]:
    """One participant: responses, times, the last attempt, and the hand, where a sensor is worn."""
    room = width - len(label)
    head: Piece = (label, "$accent bold")
    done: list[Piece] = (
        text_charts.responses(seat.trials, room) if seat.trials else [("No response yet", "$text-muted")]
    )
    times = _times(mirror, seat, room)
    attempt = _attempt(mirror, seat, room, is_short=is_short)
    in_trial = mirror.waiting is not None and mirror.waiting.stage == "trial"
    shows_attempt = is_short and ((seat.attempt is not None and not in_trial) or not seat.trials)
    rows = [[head, *done], [(" " * len(label), ""), *(attempt if shows_attempt else times)]]
    if not is_short:
        rows += [attempt, _hand(mirror, seat, room)]
    return rows


def _times(mirror: SessionState, seat: Seat, width: int) -> list[Piece]:
    if not seat.trials:
        return [("No times yet", "$text-muted")]
    decimals, unit = (mirror.welcome.decimals, mirror.welcome.unit) if mirror.welcome else (0, "")
    values = [text_charts.timed(trial) for trial in seat.trials]
    last = [f"{value:.{decimals}f}" if value is not None else "–" for value in values[-4:]]
    told = f"{' '.join(last)} {unit}".rstrip()
    line = text_charts.sparkline(values, min(20, width - len(told) - 1))
    return [(line, "$accent"), (" ", ""), (told, "")]


def _attempt(mirror: SessionState, seat: Seat, width: int, *, is_short: bool) -> list[Piece]:
    ended = seat.attempt
    if ended is None:
        return [("No attempt is done yet", "$text-muted")]
    decimals = mirror.welcome.decimals if mirror.welcome else 0
    metric = f"{ended.metric:.{decimals}f}" if ended.metric is not None else "–"
    goal = f" of {figure(ended.goal, mirror)}" if ended.goal is not None else ""
    right = f", {ended.accuracy:.0%}" if ended.accuracy is not None else ""
    sign = ("✓ ", "$success") if ended.outcome == "success" else ("✗ ", "$warning bold")
    head = "" if is_short else f"Attempt {ended.attempt} "
    return [(head, "$text-muted"), sign, (cut(f"{metric}{goal}{right}", width - len(head) - 2), "")]


def _hand(mirror: SessionState, seat: Seat, width: int) -> list[Piece]:
    if not seat.rates:
        known = mirror.sensor is not None
        return [(f"Motion sensor: {mirror.sensor.state}" if known and mirror.sensor else "", "$text-muted")]
    last = f" {abs(seat.rates[-1]):.1f} rad/s"
    return [("Hand ", "$text-muted"), (text_charts.motion(seat.rates, width - 5 - len(last)), "$accent"), (last, "")]


def _agent(mirror: SessionState, width: int) -> list[Piece]:
    if mirror.voice:
        return [(cut(f"No voice: {mirror.voice}", width), "$warning")]
    if mirror.acting is None:
        return [(f"The agent: {UNKNOWN}", "$text-muted")]
    current = mirror.standing.current if mirror.standing else None
    if not mirror.acting:
        return [("The agent is still", "$text-muted")]
    return [("▶ The agent speaks" if current is None or current.spoken else "▶ The agent moves", "$accent bold")]


# --- the log -----------------------------------------------------------------------------------------------------


def log(lines: list[Line], width: int, rows: int) -> Content:
    """The last lines, the newest at the bottom."""
    parts: list[Piece] = []
    for line in lines[-rows:] if rows > 0 else []:
        sign, style = _SIGNS[line.tone]
        parts += [
            (f"{sign} ", style),
            (cut(line.words, width - 2), "$warning" if line.tone == "bad" else ""),
            ("\n", ""),
        ]
    return Content.assemble(*parts[:-1])
