"""Texts on the session's state: the header, the participant, the log."""

from collections.abc import Callable
from datetime import datetime, timedelta

from rich.cells import cell_len
from textual.content import Content

from sar_tui.operator import text_charts
from sar_tui.operator.event_text import PAUSE_REASONS, Line, short_name
from sar_tui.operator.phrases import metric_text
from sar_tui.operator.session_state import PARTICIPANT, Seat, SessionState, Stop
from sar_tui.operator.text_charts import Piece, cut
from sar_tui.reports.charts import sparkline

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
    "visit": "asked about a visit",
}
_LINK = {"connecting": "connecting", "lost": "connection lost", "ended": "no connection"}
_WITHOUT_OPERATOR = {
    "autonomous": "If it still runs, the session goes on by itself (autonomous).",
    "silent": "If it still runs, the session goes on by itself, without anything that needs an "
    "operator.",
}
_GOES_ON = "If it still runs, the session goes on by itself."
_SIGNS = {"plain": ("·", "$text-muted"), "good": ("✓", "$success"), "bad": ("!", "$warning bold")}


def session_line(state: SessionState, width: int = 200) -> str:
    """Return the task, the participants and the progress of the session, in at most ``width``
    columns.

    If the line is too long, the task and the participants are cut or left out: the level stays.
    """
    tr, welcome = state.tr, state.welcome
    if welcome is None:
        return tr("Operator")
    progress = _progress(state)
    who = f" {tr('and')} ".join(welcome.participants.values())
    for parts in ([welcome.title, who, *progress], [who, *progress], progress):
        line = " · ".join(part for part in parts if part)
        if cell_len(line) <= width:
            return line
    return " · ".join(reversed(_progress(state, is_short=True)))


def _progress(state: SessionState, *, is_short: bool = False) -> list[str]:
    """Return the attempt, or how the session ended, and the level.

    ``is_short``: in few columns, "practice 1/2" and "level 4→5".
    """
    tr, waiting, progress = state.tr, state.waiting, []
    if state.ended:
        progress.append(tr("session {status}", status=tr(state.ended)))
    elif waiting and waiting.attempt:
        progress.append(_attempt_name(state, waiting.attempt, is_short=is_short))
    if state.level is None:
        return progress
    if state.next_level in (None, state.level):
        level = tr("level {level}", level=state.level)
    elif is_short:
        level = tr("level {level}", level=f"{state.level}→{state.next_level}")
    else:
        level = tr("level {level}, then {next}", level=state.level, next=state.next_level)
    return [*progress, level]


def _attempt_name(state: SessionState, attempt: int, *, is_short: bool) -> str:
    """Return the attempt as the participant's screen counts it: during feedback, still the one that
    ended.
    """
    tr, welcome, waiting = state.tr, state.welcome, state.waiting
    done = [seat.attempt.attempt for seat in state.seats.values() if seat.attempt]
    if waiting and waiting.stage in ("answer", "review") and done:
        attempt = max(done)
    attempt -= waiting.restarts if waiting else 0
    practice = int(welcome.parameters.get("practice_attempts", 0)) if welcome else 0
    total = welcome.attempts if welcome else 0
    if attempt <= practice:
        if is_short:
            return tr("practice {number}", number=f"{attempt}/{practice}")
        return tr("practice {number} of {total}", number=attempt, total=practice)
    number, total = attempt - practice, total - practice
    if is_short:
        return f"{number}/{total}"
    return tr("attempt {number} of {total}", number=number, total=total)


def link_status(state: SessionState, control_key: str = "b") -> Content:
    """Return the state of the link, who has control, and who else is there."""
    tr, connection = state.tr, state.connection.state
    if state.ended:
        return Content.assemble((tr("session over"), "$text-muted"))
    if connection != "connected":
        return Content.assemble((f"○ {tr(_LINK[connection])}", "$warning bold"))
    holder = tr("{name} in control", name=short_name(state.holder))
    takes = tr("{key} takes it", key=control_key)
    me = state.welcome.name if state.welcome else ""
    others = [name for name in state.peers if name not in (me, state.holder)]
    watchers = [short_name(name) for name in others if state.peers[name] == "observer"]
    parts: list[Piece] = [("● ", "$success")]
    if state.welcome and state.welcome.role == "observer":
        parts.append((tr("you are observing"), "bold"))
        parts.append((f" · {holder}", "$text-muted") if state.holder else ("", ""))
    elif state.holder == me and me:
        parts.append((tr("in control"), "$success bold"))
    elif state.holder:
        parts.append((holder, "$warning bold"))
        parts.append((f" · {takes}", "$text-muted"))
    elif not state.peers:
        parts.append((tr("connected"), "$success"))
    else:
        parts.append((tr("nobody in control"), "$warning bold"))
        parts.append((f" · {takes}", "$text-muted"))
    parts.extend(
        (f" · {short_name(name)}", "$text-muted")
        for name in others
        if state.peers[name] == "operator"
    )
    if watchers:
        watch = (
            tr("{name} watches", name=watchers[0])
            if len(watchers) == 1
            else tr("{count} watch", count=len(watchers))
        )
        parts.append((f" · {watch}", "$text-muted"))
    return Content.assemble(*parts)


def link_loss(state: SessionState) -> str:
    """Return the notice shown while the link is down; empty while it is up."""
    tr, connection = state.tr, state.connection
    parameters = state.welcome.parameters if state.welcome else {}
    reason = tr(connection.why)
    why = reason.rstrip(".")
    if state.ended:
        return ""
    if connection.state == "ended":
        closed = tr("The link is closed ({why}).", why=why) if why else tr("The link is closed.")
        return f"{closed} {tr('The panel shows the last known state.')}"
    if connection.state == "connecting" and connection.why:
        return tr("There is no connection yet: {why}", why=reason)
    if connection.state != "lost":
        return ""
    lost = tr("Connection lost ({why}).", why=why) if why else tr("Connection lost.")
    how = tr(_WITHOUT_OPERATOR.get(str(parameters.get("operator_lost")), _GOES_ON))
    return f"{lost} {how} {tr('Reconnecting.')}"


# --- the participant


def activity(state: SessionState, width: int, now: int = 0) -> Content:
    """Return what the session waits for, the prompt, each participant's results, and what the agent
    does.

    ``now``: on the session's clock (ns).
    """
    if state.welcome is None:
        return Content.assemble((state.tr("Not known yet"), "$text-muted"))
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
    tr, waiting = state.tr, state.waiting
    if state.ended:
        return tr("The session is over ({status})", status=tr(state.ended))
    if waiting is None:
        return tr("Session: not known yet")
    text = tr(_WAITING[waiting.what])
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
        text = tr("Waits for a decision")
    if waiting.what == "enter" and waiting.until:
        text = tr("The next attempt begins by itself")
    if (
        state.is_paused
        and waiting.reason in ("", *PAUSE_REASONS)
        and state.pauser
        and state.welcome
    ):
        text = _who_paused(state, list(state.welcome.participants.values()))
    if reason := tr(_REASONS.get(waiting.reason, "")):
        text += f": {reason}"
    if waiting.stage == "trial":
        return f"{text} · {tr('{number} of {total}', number=waiting.trial, total=waiting.trials)}"
    return f"{text} · {stage}" if (stage := tr(_STAGES.get(waiting.stage, ""))) else text


def _who_paused(state: SessionState, participants: list[str]) -> str:
    if state.pauser != PARTICIPANT:
        return state.tr("{who} paused", who=short_name(state.pauser))
    if len(participants) == 1:
        return state.tr("{who} paused", who=participants[0])
    return state.tr("A participant paused")


def _prompt(state: SessionState, width: int) -> list[Piece]:
    if state.prompt is None:
        return [(state.tr("No prompt is shown"), "$text-muted")]
    label = f"{state.tr('Prompt')}  "
    text = cut(state.prompt.text, width - cell_len(label))
    return [(label, "$text-muted"), (text, "$accent bold")]


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
        else [(state.tr("No response yet"), "$text-muted")]
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
        return [(state.tr("No times yet"), "$text-muted")]
    decimals, unit = (state.welcome.decimals, state.welcome.unit) if state.welcome else (0, "")
    values = [text_charts.trial_value(trial) for trial in seat.trials]
    last = [f"{value:.{decimals}f}" if value is not None else "–" for value in values[-4:]]
    text = state.tr.figures(f"{' '.join(last)} {unit}".rstrip())
    line = sparkline(values, min(20, width - len(text) - 1))
    return [(line, "$accent"), (" ", ""), (text, "")]


def _attempt(state: SessionState, seat: Seat, width: int, *, is_short: bool) -> list[Piece]:
    tr, ended = state.tr, seat.attempt
    if ended is None:
        return [(tr("No attempt finished yet"), "$text-muted")]
    decimals = state.welcome.decimals if state.welcome else 0
    result = tr.figures(f"{ended.metric:.{decimals}f}") if ended.metric is not None else "–"
    signs = {"success": ("✓ ", "$success"), "none": ("· ", "$text-muted")}
    sign = signs.get(ended.outcome, ("✗ ", "$warning bold"))
    if state.welcome and state.welcome.metric and state.welcome.metric.is_none:
        result = tr("{count} prompts", count=ended.trials)
    if ended.goal is not None:
        result = tr("{result} of {goal}", result=result, goal=metric_text(ended.goal, state))
    if ended.accuracy is not None:
        result = tr("{result}, {share}", result=result, share=f"{ended.accuracy:.0%}")
    head = "" if is_short else f"{tr('Attempt {number}', number=ended.attempt)} "
    return [(head, "$text-muted"), sign, (cut(result, width - len(head) - 2), "")]


def _hand(state: SessionState, seat: Seat, width: int) -> list[Piece]:
    tr, sensor = state.tr, state.sensor
    if not seat.rates:
        known = tr("Motion sensor: {state}", state=tr(sensor.state)) if sensor else ""
        return [(known, "$text-muted")]
    label, last = f"{tr('Hand')} ", tr.figures(f" {abs(seat.rates[-1]):.1f} rad/s")
    return [
        (label, "$text-muted"),
        (text_charts.motion(seat.rates, width - len(label) - len(last)), "$accent"),
        (last, ""),
    ]


def current_stop(state: SessionState) -> Stop | None:
    """Return the last stop until the agent acts again; None if there was none."""
    return state.stops[-1] if state.stops and not state.stops[-1].is_past else None


def _agent(state: SessionState, width: int, now: int) -> list[Piece]:
    tr = state.tr
    if stop := current_stop(state):
        text, tone = stop.outcome(now, tells_time=False)  # the log has the time that it took
        sign, style = _SIGNS[tone]
        return [(cut(f"{sign} {text[0].upper()}{text[1:]} · {stop.by}", width), style)]
    if state.voice:
        return [(cut(tr("No voice: {why}", why=state.voice), width), "$warning")]
    if state.agent.acting is None:
        return [(tr("Agent: not known yet"), "$text-muted")]
    current = state.arbiter.current if state.arbiter else None
    if not state.agent.acting:
        return [(tr("The agent is idle"), "$text-muted")]
    speaks = current is None or current.spoken
    return [(f"▶ {tr('The agent speaks' if speaks else 'The agent moves')}", "$accent bold")]


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
