"""Texts on the session's state: the header, the participant, the log."""

from collections.abc import Callable
from datetime import datetime, timedelta

from rich.cells import cell_len
from textual.content import Content

from sar_tui.operator import text_charts
from sar_tui.operator.event_text import PAUSE_REASONS, Line, participant_name, short_name
from sar_tui.operator.phrases import metric_text
from sar_tui.operator.session_state import PARTICIPANT, Seat, SessionState, Stop
from sar_tui.operator.text_charts import Piece, cut
from sar_tui.reports.charts import sparkline

UNKNOWN = "not known yet"
_LABEL = 8
"""Characters of a participant's code beside their responses."""
_WAITING = {
    "enter": "Waits for Enter",
    "start": "Waits for the start key",
    "agent": "Waits until the agent has finished",
    "answer": "Waits to give feedback",
    "step": "Waits for an answer",
    "rest": "A rest that must be taken",
    "quiet": "Waits until no key is pressed",
    "foreperiod": "A prompt is about to appear",
    "storage": "Waits for the disk",
    "response": "Waits for a response",
    "result": "The answer to a prompt is shown",
    "resume": "Paused",
    "sensor": "Waits for the motion sensor",
    "nothing": "Waits for nothing",
}
_STAGES = {"instructions": "instructions", "review": "all done"}
_REASONS = {
    **PAUSE_REASONS,
    "interrupted": "interrupted",
    "storage": "the disk",
    "held": "a key is held",
}
_SIGNS = {"plain": ("·", "$text-muted"), "good": ("✓", "$success"), "bad": ("!", "$warning bold")}


def session_line(state: SessionState, width: int = 200) -> str:
    """Return the task, the participants and the progress of the session, in at most ``width``
    columns.

    If the line is too long, the task and the participants are cut or left out: the level stays.
    """
    welcome, waiting = state.welcome, state.waiting
    if welcome is None:
        return "Operator"
    progress = []
    if state.ended:
        progress.append(f"session {state.ended}")
    elif waiting and waiting.attempt:
        progress.append(_attempt_name(state, waiting.attempt))
    if state.level is not None:
        then = f", then {state.next_level}" if state.next_level not in (None, state.level) else ""
        progress.append(f"level {state.level}{then}")
    who = " and ".join(welcome.participants.values())
    for parts in ([welcome.title, who, *progress], [who, *progress], progress):
        line = " · ".join(part for part in parts if part)
        if cell_len(line) <= width:
            return line
    return " · ".join(_shortened(part) for part in reversed(progress))


def _shortened(progress: str) -> str:
    """Return an attempt or a level in fewer columns: "practice 1 of 2" as "practice 1/2"."""
    return progress.replace("attempt ", "").replace(" of ", "/").replace(", then ", "→")


def _attempt_name(state: SessionState, attempt: int) -> str:
    """Return the attempt as the participant's screen counts it: during feedback, still the one that
    ended.
    """
    welcome, waiting = state.welcome, state.waiting
    done = [seat.attempt.attempt for seat in state.seats.values() if seat.attempt]
    if waiting and waiting.stage in ("answer", "review") and done:
        attempt = max(done)
    attempt -= waiting.restarts if waiting else 0
    practice = int(welcome.parameters.get("practice_attempts", 0)) if welcome else 0
    total = welcome.attempts if welcome else 0
    if attempt <= practice:
        return f"practice {attempt} of {practice}"
    return f"attempt {attempt - practice} of {total - practice}"


def link_status(state: SessionState, control_key: str = "b") -> Content:
    """Return the state of the link, who has control, and who else is there."""
    connection = state.connection.state
    if state.ended:
        return Content.assemble(("session over", "$text-muted"))
    if connection != "connected":
        text = {"connecting": "connecting", "lost": "connection lost", "ended": "no connection"}[
            connection
        ]
        return Content.assemble((f"○ {text}", "$warning bold"))
    me = state.welcome.name if state.welcome else ""
    others = [name for name in state.peers if name not in (me, state.holder)]
    watchers = [short_name(name) for name in others if state.peers[name] == "observer"]
    parts: list[Piece] = [("● ", "$success")]
    if state.welcome and state.welcome.role == "observer":
        parts.append(("you are observing", "bold"))
        parts.append(
            (f" · {short_name(state.holder)} in control", "$text-muted")
            if state.holder
            else ("", "")
        )
    elif state.holder == me and me:
        parts.append(("in control", "$success bold"))
    elif state.holder:
        parts.append((f"{short_name(state.holder)} in control", "$warning bold"))
        parts.append((f" · {control_key} takes it", "$text-muted"))
    elif not state.peers:
        parts.append(("connected", "$success"))
    else:
        parts.append(("nobody in control", "$warning bold"))
        parts.append((f" · {control_key} takes it", "$text-muted"))
    parts.extend(
        (f" · {short_name(name)}", "$text-muted")
        for name in others
        if state.peers[name] == "operator"
    )
    if watchers:
        watch = f"{watchers[0]} watches" if len(watchers) == 1 else f"{len(watchers)} watch"
        parts.append((f" · {watch}", "$text-muted"))
    return Content.assemble(*parts)


def link_loss(state: SessionState) -> str:
    """Return the notice shown while the link is down; empty while it is up."""
    connection, parameters = state.connection, state.welcome.parameters if state.welcome else {}
    why = f" ({connection.why.rstrip('.')})" if connection.why else ""
    if state.ended:
        return ""
    if connection.state == "ended":
        return f"The link is closed{why}. The panel shows the last known state."
    if connection.state == "connecting" and connection.why:
        return f"There is no connection yet: {connection.why}"
    if connection.state != "lost":
        return ""
    modes = {
        "autonomous": "by itself (autonomous)",
        "silent": "by itself, without anything that needs an operator",
    }
    how = modes.get(str(parameters.get("operator_lost")), "by itself")
    return f"Connection lost{why}. If it still runs, the session goes on {how}. Reconnecting."


# --- the participant


def activity(state: SessionState, width: int, now: int = 0) -> Content:
    """Return what the session waits for, the prompt, each participant's results, and what the agent
    does.

    ``now``: on the session's clock (ns).
    """
    if state.welcome is None:
        return Content.assemble((UNKNOWN.capitalize(), "$text-muted"))
    seats = sorted({*state.welcome.participants, *state.seats}) or ["A"]
    style = "$warning bold reverse" if state.is_their_pause else "bold"
    rows: list[list[Piece]] = [[(cut(waiting_text(state), width), style)], _prompt(state, width)]
    for name in seats:
        label = (
            f"{cut(state.welcome.participants.get(name, name), _LABEL)} " if len(seats) > 1 else ""
        )
        rows += _seat(state, state.seat(name), label, width, is_short=len(seats) > 1)
    rows.append(_agent(state, width, now))
    return Content.assemble(*[piece for row in rows for piece in (*row, ("\n", ""))][:-1])


def waiting_text(state: SessionState) -> str:
    """Return what the session waits for; for a pause, who made it and why."""
    waiting = state.waiting
    if state.ended:
        return f"The session is over ({state.ended})"
    if waiting is None:
        return f"Session: {UNKNOWN}"
    text = _WAITING[waiting.what]
    if waiting.step:
        text = (
            f"{text}: {waiting.step.step.text}"
            if waiting.step.step.is_question
            else waiting.step.step.text
        )
    if (
        waiting.what == "answer"
        and state.arbiter
        and any(one.deadline for one in state.arbiter.pending)
    ):
        text = "Waits for a decision"
    if waiting.what == "enter" and waiting.until:
        text = "The next attempt begins by itself"
    if (
        state.is_paused
        and waiting.reason in ("", *PAUSE_REASONS)
        and state.pauser
        and state.welcome
    ):
        theirs = state.pauser == PARTICIPANT
        text = f"{participant_name(state.welcome) if theirs else short_name(state.pauser)} paused"
    if reason := _REASONS.get(waiting.reason):
        text += f": {reason}"
    if waiting.stage == "trial":
        return f"{text} · {waiting.trial} of {waiting.trials}"
    return f"{text} · {stage}" if (stage := _STAGES.get(waiting.stage)) else text


def _prompt(state: SessionState, width: int) -> list[Piece]:
    if state.prompt is None:
        return [("No prompt is shown", "$text-muted")]
    return [("Prompt  ", "$text-muted"), (cut(state.prompt.text, width - 8), "$accent bold")]


def _seat(
    state: SessionState, seat: Seat, label: str, width: int, *, is_short: bool
) -> list[list[Piece]]:
    """Return one participant's rows: responses, times, the last attempt, and the motion of a
    hand.
    """
    room = width - len(label)
    head: Piece = (label, "$accent bold")
    done: list[Piece] = (
        text_charts.responses(seat.trials, room)
        if seat.trials
        else [("No response yet", "$text-muted")]
    )
    times = _times(state, seat, room)
    attempt = _attempt(state, seat, room, is_short=is_short)
    in_trial = state.waiting is not None and state.waiting.stage == "trial"
    shows_attempt = is_short and ((seat.attempt is not None and not in_trial) or not seat.trials)
    rows = [[head, *done], [(" " * len(label), ""), *(attempt if shows_attempt else times)]]
    if not is_short:
        rows += [attempt, _hand(state, seat, room)]
    return rows


def _times(state: SessionState, seat: Seat, width: int) -> list[Piece]:
    if not seat.trials:
        return [("No times yet", "$text-muted")]
    decimals, unit = (state.welcome.decimals, state.welcome.unit) if state.welcome else (0, "")
    values = [text_charts.trial_value(trial) for trial in seat.trials]
    last = [f"{value:.{decimals}f}" if value is not None else "–" for value in values[-4:]]
    text = f"{' '.join(last)} {unit}".rstrip()
    line = sparkline(values, min(20, width - len(text) - 1))
    return [(line, "$accent"), (" ", ""), (text, "")]


def _attempt(state: SessionState, seat: Seat, width: int, *, is_short: bool) -> list[Piece]:
    ended = seat.attempt
    if ended is None:
        return [("No attempt finished yet", "$text-muted")]
    decimals = state.welcome.decimals if state.welcome else 0
    metric = f"{ended.metric:.{decimals}f}" if ended.metric is not None else "–"
    goal = f" of {metric_text(ended.goal, state)}" if ended.goal is not None else ""
    right = f", {ended.accuracy:.0%}" if ended.accuracy is not None else ""
    signs = {"success": ("✓ ", "$success"), "none": ("· ", "$text-muted")}
    sign = signs.get(ended.outcome, ("✗ ", "$warning bold"))
    if state.welcome and state.welcome.metric and state.welcome.metric.is_none:
        metric = f"{ended.trials} prompts"
    head = "" if is_short else f"Attempt {ended.attempt} "
    return [(head, "$text-muted"), sign, (cut(f"{metric}{goal}{right}", width - len(head) - 2), "")]


def _hand(state: SessionState, seat: Seat, width: int) -> list[Piece]:
    if not seat.rates:
        known = state.sensor is not None
        return [
            (
                f"Motion sensor: {state.sensor.state}" if known and state.sensor else "",
                "$text-muted",
            )
        ]
    last = f" {abs(seat.rates[-1]):.1f} rad/s"
    return [
        ("Hand ", "$text-muted"),
        (text_charts.motion(seat.rates, width - 5 - len(last)), "$accent"),
        (last, ""),
    ]


def current_stop(state: SessionState) -> Stop | None:
    """Return the last stop until the agent acts again; None if there was none."""
    return state.stops[-1] if state.stops and not state.stops[-1].is_past else None


def _agent(state: SessionState, width: int, now: int) -> list[Piece]:
    if stop := current_stop(state):
        text, tone = stop.outcome(now, tells_time=False)  # the log has the time that it took
        sign, style = _SIGNS[tone]
        return [(cut(f"{sign} {text[0].upper()}{text[1:]} · {stop.by}", width), style)]
    if state.voice:
        return [(cut(f"No voice: {state.voice}", width), "$warning")]
    if state.agent.acting is None:
        return [(f"Agent: {UNKNOWN}", "$text-muted")]
    current = state.arbiter.current if state.arbiter else None
    if not state.agent.acting:
        return [("The agent is idle", "$text-muted")]
    return [
        (
            "▶ The agent speaks" if current is None or current.spoken else "▶ The agent moves",
            "$accent bold",
        )
    ]


# --- the log


def log_lines(
    lines: list[Line], width: int, rows: int, time_of_day: Callable[[int], str]
) -> Content:
    """Return the last lines, newest at the bottom, each with its time of day."""
    parts: list[Piece] = []
    for line in lines[-rows:] if rows > 0 else []:
        sign, style = _SIGNS[line.tone]
        time = f"{time_of_day(line.at)} "
        parts += [
            (time, "$text-muted"),
            (f"{sign} ", style),
            (
                cut(line.text_with_count, width - len(time) - 2),
                "$warning" if line.tone == "bad" else "",
            ),
            ("\n", ""),
        ]
    return Content.assemble(*parts[:-1])


def time_of_day(at: int, now: int, wall: datetime) -> str:
    """Return the local time of a moment of the session ("14:03:22"), or blanks if it is not known.

    Args:
        at: the moment (ns, session clock).
        now: the present (ns, session clock).
        wall: the present, as a date and time.
    """
    return (
        f"{wall - timedelta(microseconds=(now - at) // 1000):%H:%M:%S}"
        if at
        else " " * len("00:00:00")
    )
