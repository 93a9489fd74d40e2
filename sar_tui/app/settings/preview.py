"""The preview of the settings: what 20 attempts of this person would be like, as a picture and a
sentence.
"""

import asyncio
import statistics
import textwrap
import time
from collections.abc import Callable, Generator, Sequence
from typing import TypeVar

import msgspec
from textual.content import Content
from textual.geometry import Size
from textual.widget import Widget

from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.model.results_for_people import short_goal
from sar_tui.model.theme import Theme
from sar_tui.progress.lines import SessionResults
from sar_tui.reports.charts import BARS
from sar_tui.rules.parameters import TaskParameters
from sar_tui.runs.preview import (
    ATTEMPTS,
    Played,
    Preview,
    StandIn,
    make_stand_in,
    play_ahead,
)
from sar_tui.tui.heading import ROOMY

T = TypeVar("T")

_SLICE_S = 0.008
"""Seconds of work between two looks at the keyboard."""
_REACHED, _MISSED, _NO_GOAL = "●", "○", "·"
_BLANK_AND_BARS = f" {BARS}"
_WIDEST = 3
"""Most columns of an attempt."""
_LOWEST, _TALLEST = 4, 12
"""Rows of the bars below the fields, and beside them."""
_MOST_LINES = 2
"""Most lines of the sentence below the fields."""
_MOST_APART = 3
"""Most rows from a level to the next."""
_HALF = 0.005
"""A share is a half within this distance."""
_NEAR = 2
"""A level is settled if its highest and lowest value differ by no more than this."""


class Previews:
    """Plays previews in slices, so that the screen stays quick, and keeps them.

    Args:
        kind: the task.
        sessions: the participant's newest sessions of it, oldest first.
        find_theme: returns the theme to play with.
    """

    def __init__(
        self,
        kind: type[Task],
        sessions: Sequence[SessionResults],
        find_theme: Callable[[], Theme],
    ) -> None:
        self._kind = kind
        self._sessions = sessions
        self._find_theme = find_theme
        self._theme: Theme | None = None
        self._kept: dict[bytes, Preview] = {}
        self.stand_in: StandIn | None = None

    def kept(self, parameters: TaskParameters) -> Preview | None:
        """Return the preview of some settings, if it has been played."""
        return self._kept.get(msgspec.json.encode(parameters))

    async def play(self, parameters: TaskParameters) -> Preview:
        """Return the preview of some settings.

        Raises:
            Failed: the task cannot be played.
        """
        key = msgspec.json.encode(parameters)
        if key not in self._kept:
            theme = self._theme = self._theme or self._find_theme()
            if self._kind.sensor_seats(parameters):
                await asyncio.to_thread(_load_analysis)
            if self.stand_in is None:
                self.stand_in = await _in_slices(make_stand_in(self._kind, self._sessions, theme))
            self._kept[key] = await _in_slices(
                play_ahead(self._kind, parameters, theme, self._sessions, self.stand_in)
            )
        return self._kept[key]


def _load_analysis() -> None:
    """Import what simulated sensors need."""
    import sar_tui.runs.sensors  # noqa: F401


async def _in_slices(work: Generator[None, None, T]) -> T:
    while True:
        until = time.perf_counter() + _SLICE_S
        while time.perf_counter() < until:
            try:
                next(work)
            except StopIteration as done:
                found: T = done.value
                return found
        await asyncio.sleep(0)


# --- words


def sentence(preview: Preview, tr: Language) -> str:
    """Say in one or two sentences what happens."""
    return " ".join(filter(None, (_goals(preview, tr), _course(preview, tr), _start(preview, tr))))


def _goals(preview: Preview, tr: Language) -> str:
    """Say what the rule aims at, and what came of it: most goals are not the best."""
    if not preview.with_goal:
        return tr("This exercise has no goal.")
    found = {"reached": preview.reached, "count": preview.with_goal}
    if preview.aim is None:
        return tr("{reached} of {count} goals reached.", **found)
    if not preview.aim:
        return tr("Aims at no number of goals: {reached} of {count}.", **found)
    if (share := preview.share_of_prompts) is not None:
        return tr(
            "Aims at {aim} % of the prompts: {percent} %, and {reached} of {count} goals.",
            aim=round(100 * preview.aim),
            percent=round(100 * share),
            **found,
        )
    if abs(preview.aim - 0.5) < _HALF:
        return tr("Aims at about half of the goals: {reached} of {count}.", **found)
    return tr(
        "Aims at about {percent} % of the goals: {reached} of {count}.",
        percent=round(100 * preview.aim),
        **found,
    )


def _course(preview: Preview, tr: Language) -> str:
    if preview.follows != "goal":
        return _course_of_level(preview, tr)
    goals = [each.goal for each in preview.attempts if each.goal is not None]
    if not goals:
        return ""
    return tr(
        "The goal goes from {first} to {last}.",
        first=short_goal(preview.metric, goals[0]),
        last=short_goal(preview.metric, goals[-1]),
    )


def _course_of_level(preview: Preview, tr: Language) -> str:
    levels = [each.level for each in preview.attempts]
    late = levels[len(levels) // 2 :]
    low, high, mean = min(late), max(late), statistics.fmean(late)
    if min(levels) == max(levels):
        return tr("The level stays at {level}.", level=low)
    if late == sorted(late) and high - low > _NEAR:
        return tr("The level rises all the time, to {level}.", level=high)
    if high == preview.levels and mean > high - 0.5:
        return tr("The level reaches its highest, {level}.", level=high)
    if high - low <= _NEAR:
        return tr("The level settles near {level}.", level=round(mean))
    return tr("The level moves between {low} and {high}.", low=min(levels), high=max(levels))


def _start(preview: Preview, tr: Language) -> str:
    if not preview.why_start:
        return ""
    level, why = preview.attempts[0].level, tr(preview.why_start)
    return tr("It starts at {level} ({why}).", level=level, why=why)


def source(stand_in: StandIn, participant: str, tr: Language) -> str:
    """Say who is simulated."""
    if stand_in.sessions == 1:
        return tr("Simulated as {who} did in the last session.", who=participant)
    if stand_in.sessions:
        return tr(
            "Simulated as {who} did in the last {count} sessions.",
            who=participant,
            count=stand_in.sessions,
        )
    if not stand_in.is_like:
        return tr(
            "An average person: the results of {who} cannot be simulated.",
            who=participant,
        )
    return tr("An average person: {who} has too few results yet.", who=participant)


# --- pictures


def sparkline(preview: Preview, highest: int) -> str:
    """Draw the level of each attempt, in one line.

    Args:
        preview: the attempts.
        highest: the level that is drawn as the tallest bar; level 1 is the smallest.
    """
    return "".join(BARS[_part(each.level, 1, highest, len(BARS)) - 1] for each in preview.attempts)


def chart(preview: Preview, highest: int, columns: int, rows: int, tr: Language) -> list[Content]:
    """Draw the level of each attempt as a bar, or its goal if that is what changes; below it ● if
    the goal was reached, and ○ if not; below that, if there is room, the number of the attempt.

    Args:
        preview: the attempts.
        highest: the level that is drawn as the tallest bar; level 1 is the smallest.
        columns: the most that the drawing may take.
        rows: the most that the bars may take.
        tr: the language.
    """
    heights, labels, rows = _bars(preview, highest, rows, tr)
    count = len(preview.attempts)
    reached = tr("● reached") if preview.with_goal else ""
    attempt = tr("attempt") if rows > _LOWEST else ""
    width = max(map(len, (reached, attempt, *labels.values()))) + 1
    step = max(1, min(_WIDEST, (columns - width + 1) // count))

    def line(label: str, *parts: tuple[str, str]) -> Content:
        return Content.assemble((f"{label:>{width - 1}} ", "$text-muted"), *parts)

    drawn = []
    for row in range(rows - 1, -1, -1):
        cells = (_BLANK_AND_BARS[max(0, min(8, height - 8 * row))] for height in heights)
        bars = "".join(f"{cell * max(1, step - 1):{step}}" for cell in cells)
        drawn.append(line(labels.get(row, ""), (bars.rstrip(), "$accent")))
    marks = [(f"{mark:{step}}", style) for mark, style in map(_mark, preview.attempts)]
    drawn.append(line(reached, *marks).rstrip())
    if attempt:
        drawn.append(line(attempt, (f"{1:<{step * (count - 1)}}{count}", "$text-muted")))
    return drawn


def _bars(
    preview: Preview, highest: int, rows: int, tr: Language
) -> tuple[list[int], dict[int, str], int]:
    """Return the heights of the bars in eighths of a row, the labels by row from the lowest, and
    the number of rows. Each level has rows of its own if there are enough.
    """
    if preview.follows == "goal":
        hardness = _hardness(preview)
        low, high = min(hardness), max(hardness)
        heights = [_part(value, low, high, 8 * rows) for value in hardness]
        easiest, hardest = (
            tr.figures(short_goal(preview.metric, abs(value))) for value in (low, high)
        )
        labels = {0: easiest, rows - 1: f"{tr('goal')} {hardest}"}
        return heights, labels, rows
    levels = [each.level for each in preview.attempts]
    if apart := min(_MOST_APART, rows // highest):
        labels = {apart * level - 1: str(level) for level in range(1, highest + 1)}
        heights, rows = [8 * apart * level for level in levels], apart * highest
    else:
        labels = {0: "1", rows - 1: str(highest)}
        heights = [_part(level, 1, highest, 8 * rows) for level in levels]
    labels[rows - 1] = f"{tr('level')} {highest}"
    return heights, labels, rows


def _part(value: float, low: float, high: float, most: int) -> int:
    """Return the height of a bar between 1 and the most."""
    return 1 + round((value - low) / (high - low) * (most - 1)) if high > low else 1


def _hardness(preview: Preview) -> list[float]:
    """Return a number for each attempt that grows as its goal gets harder."""
    sign = -1.0 if preview.metric.better == "lower" else 1.0
    goals = [each.goal for each in preview.attempts if each.goal is not None]
    known = goals[0] if goals else 0.0
    found = []
    for each in preview.attempts:
        known = known if each.goal is None else each.goal
        found.append(sign * known)
    return found


def _mark(each: Played) -> tuple[str, str]:
    if each.reached is None:
        return _NO_GOAL, ""
    return (_REACHED, "$success") if each.reached else (_MISSED, "")


class PreviewPane(Widget):
    """Shows a preview, or why there is none.

    Args:
        participant: the code.
        tr: the language.
    """

    DEFAULT_CSS = "PreviewPane { height: auto; }"

    def __init__(self, participant: str, tr: Language, id: str | None = None) -> None:
        super().__init__(id=id)
        self._participant = participant
        self.tr = tr
        self._preview: Preview | None = None
        self._highest = 1
        self._heading = self._source = self._told = ""

    def show(self, heading: str, preview: Preview, stand_in: StandIn, highest: int) -> None:
        """Show a preview.

        Args:
            heading: what is played.
            preview: the attempts.
            stand_in: who played them.
            highest: the level that is drawn as the tallest bar.
        """
        self._heading, self._preview, self._told = heading, preview, ""
        self._highest = highest
        self._source = source(stand_in, self._participant, self.tr)
        self.refresh(layout=True)

    def tell(self, text: str) -> None:
        """Show a sentence in place of a preview."""
        self._preview, self._told = None, text
        self.refresh(layout=True)

    @property
    def text(self) -> str:
        """The sentence that is shown."""
        return sentence(self._preview, self.tr) if self._preview else self._told

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        return self._content(width).get_height({}, max(1, width))

    def render(self) -> Content:
        return self._content(self.content_size.width)

    def _content(self, columns: int) -> Content:
        title = Content(self.tr("Preview: {count} simulated attempts", count=ATTEMPTS))
        if self._preview is None:
            return Content("\n").join([title.stylize("bold"), Content(self._told)])
        drawn = chart(self._preview, self._highest, columns, self._rows, self.tr)
        above = [Content("")] * (self._rows - len(drawn))
        parts = [
            [self._title(title.plain, columns)],
            [*above, *drawn],
            [Content(self._sentence(columns))],
            [Content(self._source).stylize("$text-muted")],
        ]
        blank = "\n\n" if self._is_beside else "\n"
        return Content(blank).join(Content("\n").join(lines) for lines in parts)

    def _title(self, title: str, columns: int) -> Content:
        """Return the title and what is played, on one line; with a shorter title if it needs one."""
        heading = (f"  {self._heading}", "$accent")
        whole = Content.assemble((title, "bold"), heading)
        if whole.cell_length <= columns:
            return whole
        return Content.assemble((self.tr("Preview"), "bold"), heading)

    def _sentence(self, columns: int) -> str:
        """Return what happens; in a small window without the start, which the picture shows, if
        that makes it too long.
        """
        preview, tr = self._preview, self.tr
        assert preview is not None
        whole = sentence(preview, tr)
        if self._is_beside or len(textwrap.wrap(whole, max(1, columns))) <= _MOST_LINES:
            return whole
        return sentence(msgspec.structs.replace(preview, why_start=""), tr)

    @property
    def _is_beside(self) -> bool:
        """True if it stands beside the fields, so that it has all rows."""
        return self.screen.has_class("-beside")

    @property
    def _rows(self) -> int:
        """Rows of the chart."""
        rows = self.app.size.height
        if self._is_beside:
            return max(_LOWEST, min(_TALLEST, rows // 2))
        return _LOWEST if rows < ROOMY[1] else 2 * _LOWEST
