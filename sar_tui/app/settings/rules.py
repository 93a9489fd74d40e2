"""The rules of difficulty, to choose one of: a name, a picture of what happens, and a sentence."""

import textwrap
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from textual import on
from textual.app import ComposeResult
from textual.content import Content
from textual.message import Message
from textual.strip import Strip
from textual.widgets import Static
from textual.widgets.option_list import Option

from sar_tui.model.language import Language
from sar_tui.rules.declaration import Field, show
from sar_tui.rules.policies import DIFFICULTY
from sar_tui.widgets.lists import OptionList
from sar_tui.widgets.parameter_field import ParameterField

_CHOSEN = "✓"
_MARK, _PICTURE = 2, 20
"""Columns."""


class Rule(NamedTuple):
    """A rule of difficulty in words."""

    title: str
    sentence: str


class Picture(NamedTuple):
    """Outcome of a rule: the level of each attempt, drawn in one line, the lowest and the highest
    one, and how many goals are reached.
    """

    line: str
    levels: str
    reached: str


def rules(tr: Language) -> dict[str, Rule]:
    """Return the rules of difficulty by name, in words of a language."""
    return {
        name: Rule(
            tr(policy.title) if policy.title else name.replace("-", " ").capitalize(),
            tr(policy.summary) if policy.summary else "",
        )
        for name, policy in DIFFICULTY.items()
    }


class RuleList(OptionList):
    """The rules. The cursor looks at one, Enter chooses it; beyond the ends the arrows leave the
    list.
    """

    DEFAULT_CSS = """
    RuleList, RuleList:focus {
        height: auto; border: none; padding: 0; background: $background;
        background-tint: $foreground 0%; overflow: hidden;
    }
    RuleList > .option-list--option { padding: 0; }
    RuleList > .option-list--option-highlighted { background: $background; color: $foreground; text-style: none; }
    RuleList:focus > .option-list--option-highlighted {
        background: $surface; color: $accent; text-style: bold;
    }
    """

    def render_line(self, y: int) -> Strip:
        """Draw a line; the blank one below a rule never has its background."""
        strip = super().render_line(y)
        if strip.text.strip():
            return strip
        return Strip.blank(strip.cell_length, self.rich_style)

    def action_cursor_down(self) -> None:
        if (self.highlighted or 0) >= self.option_count - 1:
            self.screen.focus_next()
        else:
            super().action_cursor_down()

    def action_cursor_up(self) -> None:
        if not self.highlighted:
            self.screen.focus_previous()
        else:
            super().action_cursor_up()


class RuleField(ParameterField):
    """The setting that chooses a rule of difficulty.

    In a small window it shows the chosen rule alone, unless it has the focus, and describes only
    the rule that is looked at, below the list. Where levels cannot be drawn, words say them. A rule
    that is not there any more is shown, too.

    Args:
        field: the declaration.
        value, saved: names of rules.
        tr: the language.
    """

    DEFAULT_CSS = """
    RuleField { height: auto; }
    RuleField > .columns { height: 1; color: $text-muted; text-wrap: nowrap; text-overflow: ellipsis; }
    RuleField > .described { display: none; height: auto; margin-left: 2; color: $text-muted; }
    RuleField.-small > .columns { display: none; }
    RuleField.-small > .described { display: block; }
    RuleField.-small:focus-within > .columns { display: block; margin-top: 1; }
    RuleField > .heading { height: 1; margin-left: 2; color: $text-muted; text-style: bold; }
    """

    class LookedAt(Message):
        """The cursor is on another rule, or the list was left."""

    def __init__(self, field: Field, value: object, saved: object, tr: Language) -> None:
        super().__init__(field, value, saved, (), tr)
        self._is_small = True
        self._rules = rules(tr)
        self._pictures: Mapping[str, Picture] = {}

    def compose(self) -> ComposeResult:
        yield Static("", classes="columns", markup=False)
        yield RuleList(markup=False, compact=True)
        yield Static("", classes="described", markup=False)
        yield Static(self.tr("What this rule uses"), classes="heading", markup=False)

    def on_mount(self) -> None:
        self._fill()

    @property
    def _list(self) -> RuleList:
        return self.query_exactly_one(RuleList)

    @property
    def looked_at(self) -> str:
        """The rule under the cursor; the chosen one while the list does not have the focus."""
        if self.is_mounted and self._list.has_focus and self._list.highlighted_option:
            return self._list.highlighted_option.id or show(self.value)
        return show(self.value)

    @property
    def is_open(self) -> bool:
        """True if all rules are shown."""
        return not self._is_small or self.has_focus_within

    def show_pictures(self, pictures: Mapping[str, Picture]) -> None:
        """Show pictures of what happens under some rules."""
        if pictures != self._pictures:
            self._pictures = pictures
            self._fill()

    def use_size(self, is_small: bool) -> None:
        """Show all rules always, or in a small window while the list has the focus."""
        if is_small != self._is_small:
            self._is_small = is_small
            self._fill()

    def focus_editor(self) -> None:
        self._list.focus()

    def set_value(self, value: object) -> None:
        self.value = value
        self._fill()

    def show_problem(self, problem: str, used_by: str = "") -> None:
        if problem != self.problem:
            self.problem = problem
            self._fill()

    def redraw(self) -> None:
        """Nothing but the list is drawn."""

    def render(self) -> Content:
        return Content("")

    def _fill(self) -> None:
        """Show the rules anew, with the cursor where it was."""
        if not self.is_mounted:
            return
        value = show(self.value)
        known = dict(self._rules)
        if value not in known:
            known = {value: Rule(value or self.tr("none"), self.problem), **known}
        names = list(known) if self.is_open else [value]
        self.set_class(self._is_small, "-small")
        width = max(len(rule.title) for rule in known.values())
        at = self.looked_at
        with self.prevent(OptionList.OptionHighlighted):
            self._list.clear_options()
            self._list.add_options(
                [Option(self._option(name, known[name], width), id=name) for name in names]
            )
            self._list.highlighted = names.index(at if at in names else value)
        self.query_one(".columns", Static).update(self._heads(width))
        self._describe([known[name] for name in names])

    def _describe(self, shown: Sequence[Rule] = ()) -> None:
        """Describe the rule that is looked at below the list, with room for each of those shown, so
        that nothing below it moves.
        """
        described, looked_at = self.query_one(".described", Static), self.looked_at
        rule = self._rules.get(looked_at) or Rule("", self.problem)
        more = [self.tr("More goals reached is not better.")] if self.has_focus_within else []
        described.update("\n".join([*self._wrapped(looked_at, rule), *more]))
        if shown:
            lines = max(len(self._wrapped("", each)) for each in shown)
            described.styles.min_height = lines + len(more)

    def _wrapped(self, name: str, rule: Rule) -> list[str]:
        """Return what is said of a rule, on lines."""
        before = ""
        if name == show(self.value) and self.is_unsaved:
            saved = show(self.saved)
            was = self._rules[saved].title if saved in self._rules else saved
            before = self.tr("was {value}", value=was)
        below = " ".join(filter(None, (rule.sentence, before)))
        return textwrap.wrap(below, max(20, self.content_size.width - _MARK))

    @property
    def _columns(self) -> tuple[int, int]:
        """Columns of the levels, and of the goals that are reached."""
        shown = self._pictures.values()
        levels = max((len(each.levels) for each in shown), default=0)
        return levels, max((len(each.reached) for each in shown), default=0)

    def _is_drawn(self, width: int) -> bool:
        """Return True if levels are drawn, too, given the columns of the names of rules."""
        needed = _MARK + width + 1 + _PICTURE + sum(self._columns) + 3
        return bool(self._pictures) and needed <= self.content_size.width

    def _heads(self, width: int) -> str:
        """Return the heads of the columns."""
        levels, _ = self._columns
        head, goals = self.tr("level in 20 attempts · goals").split(" · ")
        room = _PICTURE + 1 + levels if self._is_drawn(width) else 0
        indent = min(_MARK + width + 1, self.content_size.width - len(head) - len(goals) - 3)
        between = f"{head:{room}}  " if room else f"{head} · "
        return f"{'':{max(0, indent)}}{between}{goals}"

    def _outcome(self, picture: Picture, width: int) -> tuple[str, str]:
        """Return what is drawn of a rule, and what is said beside it."""
        levels, reached = self._columns
        if self._is_drawn(width):
            return (
                f" {picture.line:{_PICTURE}}",
                f" {picture.levels:{levels}}  {picture.reached:>{reached}}",
            )
        said = self.tr("level {level}", level=picture.levels) if picture.levels else ""
        longest = len(self.tr("level {level}", level="")) + levels
        if picture.reached and _MARK + width + 1 + longest + 3 + reached <= self.content_size.width:
            said = f"{said:{longest}} · {picture.reached:>{reached}}"
        return "", f" {said}"

    def _option(self, name: str, rule: Rule, width: int) -> Content:
        is_chosen = name == show(self.value)
        picture = self._pictures.get(name, Picture("", "", ""))
        sign = self._mark[0] if is_chosen and (self.problem or self.is_unsaved) else ""
        style = "$warning" if is_chosen and self.problem else "bold" if is_chosen else ""
        drawn, said = self._outcome(picture, width)
        wrapped = [] if self._is_small else self._wrapped(name, rule)
        return Content.assemble(
            (f"{sign or (_CHOSEN if is_chosen else ''):{_MARK}}", "$accent"),
            (f"{rule.title:{width}}", style),
            (drawn, "$accent" if is_chosen else "$text-muted"),
            (said, "$text-muted not bold"),
            *((f"\n{'':{_MARK}}{line}", "$text-muted not bold") for line in wrapped),
            "" if self._is_small else "\n",
        )

    def on_resize(self) -> None:
        """Wrap the sentences anew."""
        self._fill()

    def on_descendant_focus(self) -> None:
        self._fill()
        self.post_message(self.LookedAt())

    def on_descendant_blur(self) -> None:
        self._fill()
        self.post_message(self.LookedAt())

    @on(OptionList.OptionHighlighted)
    def _moved(self, event: OptionList.OptionHighlighted) -> None:
        event.stop()
        self._describe()
        self.post_message(self.LookedAt())

    @on(OptionList.OptionSelected)
    def _picked(self, event: OptionList.OptionSelected) -> None:
        event.stop()
        if event.option.id is not None and event.option.id != show(self.value):
            self.value = event.option.id
            self._fill()
            self.post_message(self.Changed())
