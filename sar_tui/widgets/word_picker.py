"""A field for a list of words: typed, or picked from those that are known."""

from collections.abc import Sequence

from textual import on
from textual.app import ComposeResult
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Input

from sar_tui.widgets.choice import ChoiceList
from sar_tui.widgets.option_list import OptionList


class WordPicker(Widget):
    """A line to type words into. Enter opens a list of the known ones, where Enter adds a word or
    removes it.

    Args:
        known: the words to pick from.
        value: the words now, with spaces between them.
    """

    DEFAULT_CSS = """
    WordPicker { height: 1; }
    WordPicker > ChoiceList {
        width: 1fr; height: auto; max-height: 12; overlay: screen; constrain: none inside; background: $surface;
    }
    WordPicker > ChoiceList > .option-list--option { padding: 0 1; }
    """

    def __init__(self, known: Sequence[str], value: str) -> None:
        super().__init__()
        self._known = tuple(known)
        self._value = value

    def compose(self) -> ComposeResult:
        yield Input(self._value, compact=True)

    @property
    def _input(self) -> Input:
        return self.query_exactly_one(Input)

    @on(Input.Submitted)
    def _open(self, event: Input.Submitted) -> None:
        event.stop()
        words = ChoiceList(*self._lines(), compact=True)
        self.mount(words)
        words.highlighted = 0
        words.focus(scroll_visible=False)

    def _lines(self) -> list[Content]:
        chosen = self._input.value.split()
        return [Content(f"{'✓' if word in chosen else ' '} {word}") for word in self._known]

    @on(OptionList.OptionSelected)
    def _picked(self, event: OptionList.OptionSelected) -> None:
        event.stop()
        word, words = self._known[event.option_index], self._input.value.split()
        words = [each for each in words if each != word] if word in words else [*words, word]
        self._input.value = " ".join(words)
        for at, line in enumerate(self._lines()):
            event.option_list.replace_option_prompt_at_index(at, line)

    @on(OptionList.OptionHighlighted)
    def _looked_at(self, event: OptionList.OptionHighlighted) -> None:
        event.stop()
