"""The keys with which a therapist marks a trial, and the mark that is on it."""

from collections.abc import Callable, Sequence

from sar_tui.loop.marks import TrialMark
from sar_tui.model.language import Language
from sar_tui.model.trial_types import Mark


class MarkKeys:
    """Follows the marks of a session, so that one replaces another only if its key is pressed
    twice.

    Args:
        marks: of the task.
        tr: the session's language.
        trial_mark: returns the trial that a mark is put on now, and the mark that is on it.
    """

    def __init__(
        self, marks: Sequence[Mark], tr: Language, trial_mark: Callable[[], TrialMark]
    ) -> None:
        self._marks = {mark.key: mark for mark in marks}
        self._titles = {mark.name: tr(mark.title) for mark in marks}
        self.tr = tr
        self._trial_mark = trial_mark
        self._mark = TrialMark()
        self._replaces = ""

    def follow(self) -> bool:
        """Follow the session to the trial that is marked from now on. Returns True if this changes
        the text.
        """
        before = self.text
        self._mark = self._trial_mark()
        return self.text != before

    def marked(self) -> None:
        """Follow a mark that was put on a trial, or removed."""
        self.follow()
        self._replaces = ""

    def press(self, key: str) -> Mark | None:
        """Return the mark of a key; None if the key must be pressed again to replace the present
        mark.
        """
        mark = self._marks[key]
        if self._mark.present in ("", mark.name) or self._replaces == mark.name:
            self._replaces = ""
            return mark
        self._replaces = mark.name
        return None

    @property
    def asks(self) -> bool:
        """True if a key must be pressed again to replace the present mark."""
        return bool(self._mark.present and self._replaces)

    def __contains__(self, key: object) -> bool:
        return key in self._marks

    @property
    def text(self) -> str:
        """The mark that is on the trial, and the key that would replace it; empty without a
        mark.
        """
        if not self._mark.present:
            return ""
        text = self.tr(
            "Marked: {mark}", mark=self._titles.get(self._mark.present, self._mark.present).lower()
        )
        if not self.asks:
            return text
        key = next(mark.key for mark in self._marks.values() if mark.name == self._replaces)
        instead = self._titles[self._replaces].lower()
        return f"{text} · {self.tr('{key} again: {mark} instead', key=key.upper(), mark=instead)}"
