"""The versions of a programme: when, who and why; one can be looked at, compared and brought
back.
"""

from collections.abc import Sequence
from typing import ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.content import Content
from textual.widgets import Static
from textual.widgets.option_list import Option

from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.rules.declaration import Field, translated
from sar_tui.rules.parameters import Change, changes, fields
from sar_tui.store.programmes import Programme
from sar_tui.store.sessions import local_time
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.key_line import KeyLine
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.lists import MarkedList, OptionList


def compared(kind: type[Task], before: Programme, after: Programme, tr: Language) -> list[str]:
    """Return what differs between two versions, in words."""
    declared = {field.name: translated(field, tr) for field in fields(kind.Parameters)}
    found = [
        _in_words(change, declared.get(change.name), tr)
        for change in changes(kind.Parameters, before.parameters, after.parameters)
    ]
    if before.theme != after.theme:
        found.append(tr("Theme {before} → {after}", before=before.theme, after=after.theme))
    return found


def _in_words(change: Change, field: Field | None, tr: Language) -> str:
    """Return a change as the settings form shows its values: "Goal 1 → 0.9 s"."""
    if field is None:
        return change.text
    values = [field.shown(value, tr) or tr("none") for value in (change.before, change.after)]
    return f"{field.title} {' → '.join(values)} {field.on_form.unit}".rstrip()


class VersionsScreen(DismissedOnce[Programme | None]):
    """Lists the versions, the newest first; its result is the one to bring back, or None.

    Args:
        participant: the code.
        kind: the task.
        versions: the oldest first.
        tr: the language.
    """

    HORIZONTAL_BREAKPOINTS = [(130, "-beside")]
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Back", id="versions-back"),
        Binding("pagedown", "scroll(1)", "Read on", show=False, priority=True, id="versions-down"),
        Binding("pageup", "scroll(-1)", "Read back", show=False, priority=True, id="versions-up"),
    ]

    def __init__(
        self,
        participant: str,
        kind: type[Task],
        versions: Sequence[Programme],
        tr: Language,
    ) -> None:
        super().__init__()
        self.tr = tr
        self._participant = participant
        self._kind = kind
        self._versions = list(versions)

    @property
    def help_text(self) -> str:
        """Help on what is shown, and on going back."""
        return (
            self.tr(
                "Each time the settings are saved they get a new version, which is never changed. "
                "Choose one with the arrows to see what it changed, and what differs from now. "
                "Enter goes back to it: it asks why, and saves the same settings as a new "
                "version. The versions between stay in the list."
            )
            + "\n"
        )

    def compose(self) -> ComposeResult:
        tr = self.tr
        title = tr(self._kind.title)
        where = tr("{who}, {task}: versions", who=self._participant, task=title)
        yield Static(where, classes="top-bar", markup=False)
        sentence = (
            tr("Which version was better?")
            if len(self._versions) > 1
            else tr("There is one version so far.")
            if self._versions
            else tr("Nothing was saved yet: all settings are at their defaults.")
        )
        yield Static(sentence, classes="sentence", markup=False)
        yield MarkedList(
            *(Option(self._line(version), id=str(version.version))
              for version in reversed(self._versions)),
            id="versions",
            markup=False,
        )  # fmt: skip
        with VerticalScroll(id="details", can_focus=False):
            for part in ("own", "back", "all"):
                yield Static("", id=part, markup=False)
        yield KeyLine(id="key")
        yield KeyFooter()

    def on_mount(self) -> None:
        self.query_one("#versions", MarkedList).choose(None)
        self._show()

    def _line(self, version: Programme) -> Content:
        now = self.tr("now") if version is self._versions[-1] else ""
        return Content.assemble(
            (f"{version.version:>3}  {local_time(version.created_at)}  ", ""),
            (f"{version.author:<12.12}  ", "$text-muted"),
            version.reason or self.tr("no reason given"),
            (f"  {now}", "$accent bold"),
        )

    @property
    def _chosen(self) -> int | None:
        """The place of the chosen version among all."""
        at = self.query_one("#versions", MarkedList).highlighted
        return None if at is None or not self._versions else len(self._versions) - 1 - at

    @on(OptionList.OptionHighlighted)
    def _show(self) -> None:
        """Show what differs."""
        tr, at = self.tr, self._chosen
        key = self.query_one("#key", KeyLine)
        if at is None:
            self.query_one("#own", Static).update(
                tr("Change a setting and save it with Ctrl-S: it is listed here.")
            )
            key.show(tr("Esc goes to the settings."), "Esc")
            return
        version, now = self._versions[at], self._versions[-1]
        before = self._versions[at - 1] if at else Programme()
        number = version.version
        self._tell("#own", tr("Version {number} changed", number=number), before, version)
        self._tell("#back", tr("Going back to it changes"), now, version)
        self._tell(
            "#all",
            tr("Not at the default in version {number}", number=number),
            Programme(theme=version.theme),
            version,
        )
        self.query_one("#back").display = version is not now
        if version is now:
            key.show(tr("These are the settings now. Esc goes to them."), "Esc")
        else:
            key.show(tr("Enter goes back to version {number}.", number=number), "Enter")

    def _tell(self, part: str, heading: str, before: Programme, after: Programme) -> None:
        """Show what differs between two versions, under a heading."""
        differs = compared(self._kind, before, after, self.tr) or [self.tr("nothing")]
        lines = [Content(heading).stylize("bold"), *(Content(f"  {line}") for line in differs)]
        self.query_one(part, Static).update(Content("\n").join(lines))

    def action_scroll(self, direction: int) -> None:
        """Scroll what differs by a page."""
        details = self.query_one("#details", VerticalScroll)
        details.scroll_relative(y=direction * max(1, details.size.height - 1), animate=False)

    @on(OptionList.OptionSelected)
    def _bring_back(self) -> None:
        at = self._chosen
        if at is not None and self._versions[at] is not self._versions[-1]:
            self.dismiss(self._versions[at])
