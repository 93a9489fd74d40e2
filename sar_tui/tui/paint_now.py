"""Painting at a given moment: Textual paints at most 60 times a second, and may be up to 17 ms
late.
"""

from textual.widget import Widget


def paint_now(widget: Widget, *, in_place: bool = False) -> None:
    """Write what has changed in a widget to the terminal, without waiting for Textual's next paint.

    If another screen covers it, Textual paints as usual; also if the screen must be laid out first,
    unless the widget is to be painted ``in_place``, where it was laid out before.
    """
    screen = widget.screen
    if screen.is_current and (in_place or not (screen._layout_required or screen._scroll_required)):
        screen._compositor.update_widgets({widget})
        screen._compositor_refresh()
