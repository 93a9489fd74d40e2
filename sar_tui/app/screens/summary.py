"""The summary of a session for its participant: praise, one picture, and what comes next."""

from collections.abc import Callable, Sequence
from itertools import accumulate, zip_longest
from typing import NamedTuple

from textual.app import ComposeResult
from textual.containers import Center, Vertical
from textual.content import Content
from textual.widgets import Static

from sar_tui.app.screens.message_panel import rows_of_text
from sar_tui.model.language import Language
from sar_tui.model.line_breaks import spaced
from sar_tui.model.messages import AttemptEnded
from sar_tui.model.results_for_people import result_text
from sar_tui.model.spoken_text import sentences
from sar_tui.model.trial_types import Metric
from sar_tui.tui.base_app import on_linux_console
from sar_tui.tui.heading import ONE_LINE, Heading, figures_in_blocks, is_roomy
from sar_tui.widgets.block_digits import draw_share
from sar_tui.widgets.language import language_of

REACHED, OPEN = "●", "○"
"""An attempt that reached its goal, and one that did not."""
_SPACE = "\N{NO-BREAK SPACE}"
"""A space that stays where lines are centred."""
_GAP = 4
"""Columns between words and the picture beside them."""
_BESIDE = 50
"""Most columns of the praise beside the agent."""
_LARGEST = 8
"""Most rows of the praise in a large window."""


class Layout(NamedTuple):
    """Sizes of one participant's facts.

    Attributes:
        between: what parts one fact from the next.
        before_picture: what parts the facts from the picture.
        rows: of the picture of levels.
        widest: most columns of an attempt.
        margins: blank rows above and below all of it.
        has_figures: the number of goals that were reached is in large figures.
        gap: blank rows between levels and marks.
        has_levels: a sentence says the first and the last level, too.
    """

    between: str
    before_picture: str
    rows: int
    widest: int
    margins: int
    has_figures: bool = False
    gap: int = 0
    has_levels: bool = False


LARGE = Layout("\n\n", "\n\n", 5, 6, margins=7, has_figures=True, gap=1)
_LAYOUTS = (
    LARGE._replace(has_levels=True, margins=10),
    LARGE,
    LARGE._replace(has_figures=False),
    LARGE._replace(has_figures=False, gap=0),
    SMALL := Layout("\n\n", "\n", 2, 4, margins=2, has_figures=True),
    Layout("\n", "\n\n", 2, 4, margins=2),
    Layout("\n", "\n", 1, 4, margins=2),
)
"""From the largest to the smallest."""


class Summary(Vertical):
    """Shows how a session went, kindly.

    The picture has a mark for each attempt, and the highest level so far above it: a curve that
    never falls. Without a goal that was reached, there is none.

    Args:
        metric: the task's metric.
        more_facts: sentences that the task's view adds for one seat's attempts.
        show_beside: shows the praise in another place, if there is one; it returns False if not.
    """

    def __init__(
        self,
        metric: Metric,
        more_facts: Callable[[Sequence[AttemptEnded]], Sequence[str]] = lambda _: (),
        show_beside: Callable[[Content], bool] = lambda _: False,
        *,
        id: str | None = None,
    ) -> None:
        super().__init__(id=id)
        self._metric = metric
        self._more_facts = more_facts
        self._show_beside = show_beside
        self._attempts: tuple[Sequence[AttemptEnded], ...] = ()
        self._names: Sequence[str] = ()
        self._status = ""
        self._session = self._earlier = self._next = ""

    def compose(self) -> ComposeResult:
        yield Heading(id="praise", largest=_LARGEST)
        yield Static("", id="which", classes="body", markup=False)
        yield Center(Static("", id="facts", markup=False))
        yield Static("", id="earlier", classes="body", markup=False)
        yield Static("", id="next", classes="body strong", markup=False)

    def show(
        self,
        *attempts: Sequence[AttemptEnded],
        status: str = "completed",
        names: Sequence[str] = (),
        what_next: str = "",
    ) -> None:
        """Show the scored attempts, of each seat if there are several.

        Args:
            attempts: of each seat.
            status: of the session; ``mistake`` if it was started by mistake.
            names: the participants', by seat.
            what_next: when they meet again, or the next exercise.
        """
        self._attempts, self._names = attempts, names
        self._status, self._next = status, what_next
        self._draw()

    def tell_session(self, number: int) -> None:
        """Add the number of the session among those of its participant."""
        tr = language_of(self.app)
        self._session = tr("That was session {number}.", number=number)
        self._draw()

    def compare(self, words: str) -> None:
        """Add how the session compares with an earlier one."""
        self._earlier = words
        self._draw()

    @property
    def sentences(self) -> list[str]:
        """The summary in sentences, without its picture."""
        if not self._status:
            return []
        tr = language_of(self.app)
        end = ending(self._status, any(self._attempts), tr)
        words = [end.text] if end.text else self._words(tr)
        return sentences(end.headline, self._session, *words, self._earlier, self._next)

    def _words(self, tr: Language) -> list[str]:
        """Return what is said of each seat."""
        found: list[str] = []
        for index, attempts in enumerate(self._attempts):
            found += self._names[index : index + 1]
            found += facts(attempts, self._metric, tr)
            found += self._more_facts(attempts)
        return found

    def on_resize(self) -> None:
        self._draw()

    def _draw(self) -> None:
        if not self._status:
            return
        tr = language_of(self.app)
        end = ending(self._status, any(self._attempts), tr)
        praise = self.query_one("#praise", Heading)
        is_done = self._status == "completed"
        praise.set_classes("well-done" if is_done else "sentence")
        words = spaced(end.headline, _BESIDE) if is_done else end.headline
        beside = Content.styled(words, "bold $success" if is_done else "bold $accent")
        if self._session:
            beside = beside + Content(f"\n{self._session}")
        is_beside = self._show_beside(beside)
        praise.show("" if is_beside else end.headline)
        self._put("which", "" if is_beside else self._session)
        alone = Content("")
        if len(self._attempts) == 1:
            alone = self._facts_of_one(tr, is_beside=is_beside)
        self._put("facts", end.text or alone or self._facts(tr))
        self.query_one("#facts").set_class(bool(end.text or alone), "body")
        self._put("earlier", self._earlier)
        self._put("next", self._next)

    def _put(self, name: str, text: "str | Content") -> None:
        part = self.query_one(f"#{name}", Static)
        part.update(text)
        part.display = bool(text)

    def _facts(self, tr: Language) -> Content:
        """Return words and picture of each seat, with all pictures below each other."""
        room = self.content_size.width or self.app.size.width
        parts: list[Content] = []
        for index, attempts in enumerate(self._attempts):
            if index:
                parts.append(Content(""))
            if self._names:
                parts.append(Content.styled(self._names[index], "$text-muted"))
            words = facts(attempts, self._metric, tr)
            parts += beside(words, attempts, room)
            parts += map(Content, self._more_facts(attempts))
        return Content("\n").join(parts)

    def _facts_of_one(self, tr: Language, *, is_beside: bool) -> Content:
        """Return words with the picture below them, as large as there is room; empty if there is
        none. ``is_beside``: the praise stands in another place.
        """
        attempts = self._attempts[0]
        width, height = self.content_size
        is_large = is_roomy(*self.app.size)
        others = (self._earlier, self._next)
        left = height - sum(rows_of_text(text, width) for text in others)
        if is_beside:
            left += 1  # without the blank row below the praise
        else:
            left -= (ONE_LINE if is_large else 1) + rows_of_text(self._session, width)
        for layout in _LAYOUTS if is_large else _LAYOUTS[_LAYOUTS.index(SMALL) :]:
            picture = draw_picture(attempts, width, tr, layout)
            told = facts(attempts, self._metric, tr, has_levels=layout.has_levels)
            said = [*told, *self._more_facts(attempts)]
            first = said[0]
            if layout.has_figures and _is_good(attempts):
                first = "\n".join(_large(first, width, is_large=is_large)) or first
            words = Content(layout.between).join(
                [Content.styled(first, _style_of_goals(attempts)), *map(Content, said[1:])]
            )
            parts = [words, *([picture] if picture else [])]
            whole = Content(layout.before_picture).join(parts)
            if whole.plain.count("\n") + 1 + layout.margins <= left:
                return whole
        return Content("")


def _large(text: str, width: int, *, is_large: bool) -> list[str]:
    """Return the rows of the goals that were reached, in large figures; none if there is no way."""
    if is_large:
        return figures_in_blocks(text, width, is_below=True)
    # its font has no half blocks
    return [] if on_linux_console() else draw_share(text)


class _Ending(NamedTuple):
    """Words on the end of a session: headline, and a text that takes the place of its facts, or empty."""

    headline: str
    text: str = ""


def ending(status: str, has_attempts: bool, tr: Language) -> _Ending:
    """Return the words on the end of a session with this status."""
    match status:
        case "refused":
            return _Ending(
                tr("That is all right"),
                tr("The session does not begin, and nothing but this answer is kept. Thank you."),
            )
        case "mistake":
            return _Ending(tr("That is all right"), tr("This session does not count."))
        case "completed":
            return _Ending(tr("Well done"))
    if has_attempts:
        return _Ending(tr("Thank you for today"))
    return _Ending(tr("Thank you for today"), tr("No attempt was finished. That is all right."))


def facts(
    attempts: Sequence[AttemptEnded], metric: Metric, tr: Language, *, has_levels: bool = True
) -> list[str]:
    """Return what one person did: goals reached, levels, the best result. Nothing that was missed.

    ``has_levels``: False where a picture shows the levels.
    """
    count = len(attempts)
    reached = [attempt for attempt in attempts if attempt.outcome == "success"]
    done = tr("You did 1 attempt.") if count == 1 else tr("You did {count} attempts.", count=count)
    if not reached:
        return [done]
    said = [tr("{reached} of {count} goals reached", reached=len(reached), count=count)]
    levels = _levels_in_words([attempt.level for attempt in attempts], tr)
    if levels and has_levels:
        said.append(levels)
    results = [attempt.metric for attempt in reached if attempt.metric is not None]
    if results:
        best = (min if metric.better == "lower" else max)(results)
        said.append(tr("Your best: {best}", best=result_text(metric, best, tr)))
    return said


def _levels_in_words(levels: Sequence[int], tr: Language) -> str:
    first, last, highest = levels[0], levels[-1], max(levels)
    if highest == first:
        return ""
    if last == highest:
        return tr("You began at level {first} and finished at level {last}", first=first, last=last)
    return tr("You began at level {first} and got up to level {last}", first=first, last=highest)


def beside(words: list[str], attempts: Sequence[AttemptEnded], room: int) -> list[Content]:
    """Return words with a picture of two rows beside them, or below them where there is no room."""
    drawn = [_marks(attempts, 2), *_levels(attempts, 1, 2)] if _is_good(attempts) else []
    left = max(map(len, words))
    right = max((line.cell_length for line in drawn), default=0)
    if left + _GAP + right > room:
        return [*map(Content, words), *drawn]
    rows = zip_longest(words, drawn, fillvalue="")
    return [Content(str(line).ljust(left + _GAP)).append(row) for line, row in rows]


def draw_picture(
    attempts: Sequence[AttemptEnded], room: int, tr: Language, layout: Layout
) -> Content:
    """Return the levels as columns above a mark for each attempt, with words for both. Empty
    without a goal that was reached.
    """
    if not _is_good(attempts):
        return Content("")
    goals, level = tr("goal reached"), tr("level")
    left = max(len(goals), len(level)) + 1
    step = max(1, min(layout.widest, (room - left) // len(attempts)))
    step -= step > 1 and step % 2  # a mark has a middle only in an odd number of columns
    marks = _marks(attempts, step)
    named = [("", row) for row in _levels(attempts, layout.rows, step, has_ends=True)]
    if named:
        named[-1] = (level, named[-1][1])
        named += [("", Content(_SPACE * marks.cell_length))] * layout.gap
    named.append((goals, marks))
    lines = [
        Content.assemble((f"{name:{_SPACE}>{left - 1}}{_SPACE}", "$text-muted"), row)
        for name, row in named
    ]
    return Content("\n").join(lines)


def _is_good(attempts: Sequence[AttemptEnded]) -> bool:
    """Return True if there is something to be glad of: a picture of no goals would not be kind."""
    return any(attempt.outcome == "success" for attempt in attempts)


def _style_of_goals(attempts: Sequence[AttemptEnded]) -> str:
    """Return the style of the number of goals that were reached: green only if they are most."""
    if not _is_good(attempts):
        return ""
    reached = sum(attempt.outcome == "success" for attempt in attempts)
    return "bold $success" if 2 * reached >= len(attempts) else "bold"


def _marks(attempts: Sequence[AttemptEnded], step: int) -> Content:
    """Return a mark for each attempt, so many columns apart."""
    marks = [REACHED if attempt.outcome == "success" else OPEN for attempt in attempts]
    return Content.assemble(
        *(
            (
                mark.center(max(1, step - 1)).ljust(step).replace(" ", _SPACE),
                "$success" if mark == REACHED else "",
            )
            for mark in marks
        )
    )


def _levels(
    attempts: Sequence[AttemptEnded], rows: int, step: int, *, has_ends: bool = False
) -> list[Content]:
    """Return the highest level so far of each attempt as columns from zero; nothing if it never
    rose. ``has_ends``: the first and the last level stand above their columns, in a row more.
    """
    from sar_tui.reports.charts import BARS

    highest = list(accumulate((attempt.level for attempt in attempts), max))
    if highest[0] == highest[-1]:
        return []
    most = rows * len(BARS)
    heights = [max(1, round(level / highest[-1] * most)) for level in highest]
    width = max(1, step - 1)
    lines = []
    for row in reversed(range(rows + has_ends)):
        cells = [(_cell(height - row * len(BARS), BARS) * width, "$accent") for height in heights]
        for at in (0, -1):
            level = f"{highest[at]}"
            if has_ends and len(level) <= step and row == -(-heights[at] // len(BARS)):
                cells[at] = (level.center(width), "$text-muted")
        lines.append(
            Content.assemble(
                *((text.ljust(step).replace(" ", _SPACE), style) for text, style in cells)
            )
        )
    return lines


def _cell(filled: int, bars: str) -> str:
    return bars[min(filled, len(bars)) - 1] if filled > 0 else " "
