"""The agent: a small drawn robot that speaks, looks and moves, with its words beside it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.css.scalar import Unit
from textual.geometry import Size
from textual.widget import Widget
from textual.widgets import Static

from sar_tui.loop.clock import Clock, Handle
from sar_tui.model.gesture import REST, Gesture, Pose
from sar_tui.model.line_breaks import balanced
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.widgets.robot import HEIGHT, WIDTH, draw, posed, with_mouth

FRAME = SECOND // 15
"""Time between two frames of a moving robot."""
MOUTH = SECOND // 6
"""Time between opening and shutting the mouth while a voice sounds."""
_SENTENCE = 72
"""Columns of words in a box whose width is not known yet."""
_VALENCES = ("positive", "neutral", "negative")


class Agent(Horizontal):
    """Shows the agent and its last words.

    It moves on the session's clock, for gestures and to move its mouth with a voice; while held it
    is still.

    Args:
        theme: has the faces.
        clock: drives its motion.
        picture: the widget that shows pictures, if the terminal can; an expression with a picture
            does not move.
        folder: of the theme's pictures.
    """

    DEFAULT_CSS = f"""
    Agent {{ height: auto; min-height: {HEIGHT}; max-height: 13; padding: 0 1; }}
    Agent > .picture {{ width: {WIDTH}; height: {HEIGHT}; display: none; }}
    Agent > .robot {{ width: {WIDTH}; height: {HEIGHT}; color: $accent; }}
    Agent > .beside {{ width: 1fr; height: auto; }}
    Agent .words {{ width: 100%; height: auto; padding: 1 1 0 2; }}
    Agent .words > Static {{ width: 100%; height: auto; }}
    Agent .words > .more, Agent .words > .note {{ margin-top: 1; display: none; }}
    Agent .words > .note {{ color: $text-muted; }}
    Agent .below {{ width: auto; height: auto; margin: 1 0 0 2; display: none; }}
    Agent > .tail {{ display: none; width: 1; height: 1; margin: 3 0 0 1; color: $accent; }}
    """

    def __init__(
        self,
        theme: Theme,
        clock: Clock,
        picture: type[Widget] | None = None,
        folder: Path | None = None,
        id: str | None = None,
    ) -> None:
        super().__init__(id=id)
        self._theme = theme
        self._clock = clock
        self.face = "neutral"
        self._gaze = "ahead"
        self._gesture: Gesture | None = None
        self._began, self._from = 0, REST
        self._sounds_since: int | None = None
        self.is_held = False
        self._next: Handle | None = None
        self._drawn = ""
        self._robot = Static(classes="robot")
        self._picture: Any = picture(classes="picture") if picture and folder else None
        self._folder = folder
        self._pictures: dict[str, Any] = {}
        self._said = _Words(classes="said", markup=False)
        self._more = _Words(classes="more", markup=False)
        self._note = Static(classes="note", markup=False)
        self._below = Static(classes="below")
        self._has_words = False
        self._text = self._joined = ""
        self._left_out: Sequence[str] = ()
        self._still: Pose | None = None

    def compose(self) -> ComposeResult:
        if self._picture:
            yield self._picture
        yield self._robot
        yield Static("◁", classes="tail")
        with Vertical(classes="beside"):
            with Vertical(classes="words"):
                yield self._said
                yield self._more
                yield self._note
            yield self._below

    def on_mount(self) -> None:
        self._load_pictures()
        self.look(self.face)

    def on_unmount(self) -> None:
        self.hold()

    # --- words and expression

    def say(
        self, text: str, face: str = "", valence: str | None = None, *, joins: bool = False
    ) -> None:
        """Show words until the next ones; an empty text keeps those shown.

        Args:
            text: the words.
            face: the expression (see `theme.FACES`); empty to keep it.
            valence: sets the colour of the words.
            joins: adds the words below those shown.
        """
        if text and joins and self._has_words:
            self._joined = f"{self._joined}\n{text}" if self._joined else text
            self._put(self._more, self._joined)
        elif text:
            self._has_words = True
            self.update_classes({"speaks": True} | {name: valence == name for name in _VALENCES})
            self._text, self._joined = text, ""
            self._said.update(_without(text, self._left_out))
            self._put(self._more, "")
        if face:
            self.look(face)

    def leave_out(self, phrases: Sequence[str]) -> None:
        """Leave phrases out of the words, unless they are all of them, because they can be read
        elsewhere on the screen.
        """
        if phrases != self._left_out:
            self._left_out = phrases
            self._said.update(_without(self._text, phrases))

    def clear(self, face: str) -> None:
        """Remove the words, and look ahead."""
        if self._has_words:
            self._has_words = False
            self.remove_class("speaks")
            self._said.update("")
            self._text = self._joined = ""
            self._put(self._more, "")
        self._gaze = "ahead"
        self.look(face)

    def look(self, face: str) -> None:
        """Change the expression only."""
        self.face = face if face in self._theme.faces else "neutral"
        self._show_picture()
        self._go_on()

    def note(self, text: str) -> None:
        """Show a note below the words, which the agent does not say; empty for none."""
        self._put(self._note, text)

    def show_below(self, words: Content) -> None:
        """Show words below the box with those of the agent; empty for none."""
        self._below.display = bool(words)
        self._below.update(words)

    def apply_theme(self, theme: Theme) -> None:
        """Use the faces of another theme."""
        if theme != self._theme:
            self._theme = theme
            self._load_pictures()
            self.look(self.face)

    # --- motion

    def gesture(self, gesture: Gesture) -> None:
        """Move through a gesture, from where the body is now."""
        self._from = self._pose
        self._gesture, self._began = gesture, self._clock.now()
        self._go_on()

    def gaze(self, where: str) -> None:
        """Look somewhere (see `theme.GAZES`)."""
        self._gaze = where
        self._go_on()

    def cue(self, gaze: str, gesture: Gesture | None = None) -> None:
        """Look somewhere, or take the farthest pose of a gesture, in a single frame, also while
        held.

        The pose stays until ``release``. A picture, which can neither look nor point, is replaced
        by the drawing.
        """
        self._gaze = gaze or "ahead"
        self._still = gesture.farthest if gesture else REST
        if self._picture:
            self._picture.display, self._robot.display = False, True
        self._draw()

    def speaking(self, sounds: bool) -> None:
        """Move the mouth while ``sounds``; otherwise shut it."""
        if sounds != (self._sounds_since is not None):
            self._sounds_since = self._clock.now() if sounds else None
            if not self.is_held:
                self._show_picture()
            self._go_on()

    def be_still(self) -> None:
        """Rest at once, except for the mouth, which follows the voice."""
        self._gesture = None
        self._gaze = "ahead"
        self._go_on()

    def hold(self) -> None:
        """Rest, and draw nothing more until ``release``, because a response is awaited."""
        if not self.is_held:
            self.is_held = True
            self._gesture, self._gaze = None, "ahead"
            self._cancel()
            self._draw()

    def release(self) -> None:
        """Move again."""
        if self.is_held:
            self.is_held = False
            if self._still:
                self._still, self._gaze = None, "ahead"
            self.look(self.face)

    @property
    def is_moving(self) -> bool:
        """True if it will be drawn again by itself."""
        return self._next is not None

    @property
    def _pose(self) -> Pose:
        if self._gesture is None:
            return self._still or REST
        return self._gesture.pose_at((self._clock.now() - self._began) / MS, self._from)

    def _go_on(self) -> None:
        """Draw this frame, and schedule the next while something moves."""
        self._cancel()
        if self.is_held:
            return
        if self._gesture and self._clock.now() - self._began >= self._gesture.duration_ms * MS:
            self._gesture = None
        self._draw()
        if self._gesture or self._sounds_since is not None:
            self._next = self._clock.call_at(self._clock.now() + FRAME, self._go_on)

    def _cancel(self) -> None:
        if self._next:
            self._next.cancel()
            self._next = None

    def _draw(self) -> None:
        drawing = "\n".join(draw(self._lines(), posed(self._pose, self._gaze)))
        if drawing != self._drawn and self._robot.is_attached:
            self._drawn = drawing
            self._robot.update(Text(drawing), layout=False)

    def _lines(self) -> list[str]:
        """Return the lines of the face, its mouth moving if a voice sounds, and shut otherwise."""
        faces, line = self._theme.faces, self._theme.mouth_line
        face = faces[self.face].splitlines()
        is_moving = self._sounds_since is not None and not self.is_held
        if is_moving and (self._clock.now() - (self._sounds_since or 0)) // MOUTH % 2 == 0:
            return with_mouth(face, line, faces["speaking"].splitlines())
        return with_mouth(face, line, faces[self._silent_face].splitlines())

    @property
    def _silent_face(self) -> str:
        """The expression whose mouth it has without a voice: the face ``speaking`` has an open
        one.
        """
        return "neutral" if self.face == "speaking" else self.face

    def _show_picture(self) -> None:
        """Show the picture of the expression; the drawing if there is none."""
        if not self._picture or self._still:
            return
        picture = self._pictures.get(self._silent_face if self._sounds_since is None else self.face)
        self._picture.display = picture is not None
        self._robot.display = picture is None
        if picture is not None and self._picture.image is not picture:
            self._picture.image = picture

    def _load_pictures(self) -> None:
        """Load all pictures at once, so that no file is read when a face changes."""
        if self._picture and self._folder:
            self._pictures = load_pictures(
                {name: self._folder / file for name, file in self._theme.images.items()}
            )

    def _put(self, words: Static, text: str) -> None:
        words.display = bool(text)
        words.update(text)


def _without(text: str, phrases: Sequence[str]) -> str:
    """Return a text without some phrases; the text if nothing else is in it."""
    left = text
    for phrase in phrases:
        left = left.replace(phrase, "")
    return " ".join(left.split()) or text if left != text else text


class _Words(Static):
    """Words of the agent, on lines of about the same length, and no wider than the longest."""

    def _balanced(self, columns: int) -> Content:
        return Content(balanced(str(self.content), columns or _SENTENCE))

    def get_content_width(self, container: Size, viewport: Size) -> int:
        columns = container.width
        box = self.parent
        if isinstance(box, Widget) and (most := box.styles.max_width) and most.unit is Unit.CELLS:
            columns = int(most.value) - box.gutter.width
        return max(
            line.cell_length for line in self._balanced(columns).split("\n", allow_blank=True)
        )

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        return self._balanced(width).get_height({}, max(1, width))

    def render(self) -> Content:
        return self._balanced(self.content_size.width)


# --- a picture


_PIXELS = (20 * WIDTH, 40 * HEIGHT)
"""Size to scale pictures to: characters are about twice as high as wide."""


def find_pictures() -> type[Widget] | None:
    """Return the widget that shows pictures in this terminal; None if it cannot, or the extra
    ``images`` is missing.

    Asks the terminal for its protocols (kitty, sixel), so it must be called before an app runs.
    """
    try:
        from textual_image.renderable import Image, SixelImage, TGPImage

        if Image not in (SixelImage, TGPImage):
            return None
        from textual_image.widget import Image as Picture
    except Exception:  # not installed, or an unexpected answer from the terminal
        return None
    found: type[Widget] = Picture
    return found


def load_pictures(files: Mapping[str, Path]) -> dict[str, Any]:
    """Return pictures by name, decoded and of one size, without files that cannot be read."""
    from PIL import Image, ImageOps

    pictures = {}
    for name, path in files.items():
        try:
            with Image.open(path) as picture:
                pictures[name] = ImageOps.pad(picture.convert("RGBA"), _PIXELS, color=(0, 0, 0, 0))
        except Exception:  # a decoder may raise anything for a broken file
            continue
    return pictures
