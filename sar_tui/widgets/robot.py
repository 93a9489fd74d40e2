"""The agent's body as characters: a head with its face, shoulders and two arms, drawn in a pose."""

from collections.abc import Sequence

from sar_tui.model.gesture import Pose

WIDTH, HEIGHT = 21, 7
"""Columns and lines of a drawing, whatever the pose."""
GAZES = {
    "left": Pose(turn=-0.5),
    "right": Pose(turn=0.5),
    "up": Pose(nod=-0.5),
    "down": Pose(nod=0.5),
}
"""Pose to add for a gaze."""
_SEEN = 0.25
"""Smallest distance from rest at which a joint is drawn differently."""
_LEANS = 0.25
_OUT, _SLANTED, _UP = 0.15, 0.45, 0.75
"""Positions from which an arm is drawn stretched out, slanted, straight up."""
_HEAD_TOP, _SHOULDERS = 1, 5
_PLAIN = str.maketrans("╭╮╰╯─│╱╲●", "++++-|/\\o")
"""Characters of the body for a face in ASCII."""

Cells = list[list[str]]


def posed(pose: Pose, gaze: str = "ahead") -> Pose:
    """Return a pose that looks somewhere (see `theme.GAZES`)."""
    look = GAZES.get(gaze)
    if look is None:
        return pose
    return Pose(
        _add(pose.nod, look.nod),
        _add(pose.turn, look.turn),
        pose.left_arm,
        pose.right_arm,
        pose.lean,
    )


def draw(face: Sequence[str], pose: Pose) -> list[str]:
    """Draw the robot in a pose: ``HEIGHT`` lines of ``WIDTH`` characters.

    Args:
        face: its lines, all of one width, at most 11 characters by 4 lines.
        pose: positions of the joints; 0 is rest. Small deviations are not drawn.
    """
    cells = [[" "] * WIDTH for _ in range(HEIGHT)]
    leans = pose.lean >= _LEANS
    half = 6 if leans else 4
    middle = WIDTH // 2
    _put(cells, middle - half, _SHOULDERS, "╭" + "─" * (2 * half - 1) + "╮")
    _put(cells, middle - half, _SHOULDERS + 1, "│" + " " * (2 * half - 1) + "│")
    for side, raised in ((-1, pose.left_arm), (1, pose.right_arm)):
        _put_arm(cells, middle + side * half, side, raised)
    if all(line.isascii() for line in face):
        cells = [list("".join(row).translate(_PLAIN)) for row in cells]
    _put_head(cells, face, pose, leans=leans)
    return ["".join(row) for row in cells]


def with_mouth(face: Sequence[str], mouth_line: int, mouth: Sequence[str]) -> list[str]:
    """Return a face with the mouth of another."""
    lines = list(face)
    if mouth_line < min(len(lines), len(mouth)):
        lines[mouth_line] = mouth[mouth_line]
    return lines


def _put_head(cells: Cells, face: Sequence[str], pose: Pose, *, leans: bool) -> None:
    """Draw the head over the body: turned, its features move; leaning in, it covers the
    shoulders.
    """
    lines = _turned(face, _step(pose.turn))
    top = _HEAD_TOP + (4 - len(lines)) + max(-1, min(1, _step(pose.nod) + leans))
    left = (WIDTH - len(lines[0])) // 2
    if len(lines) < 3 or abs(pose.turn) >= _UP:
        left += _step(pose.turn)
    bottom = top + len(lines)
    if bottom < _SHOULDERS:
        _put(
            cells,
            WIDTH // 2 - 1,
            bottom,
            "│ │" if any(not line.isascii() for line in face) else "| |",
        )
    for row, line in enumerate(lines):
        for column, character in enumerate(line):
            is_outside = not line[:column].strip() or not line[column:].strip()
            if character != " " or not is_outside:
                _put(cells, left + column, top + row, character)
    if bottom == _SHOULDERS:
        _join(cells)


def _join(cells: Cells) -> None:
    """Draw a neck between a head and the shoulders right below it."""
    for column in (WIDTH // 2 - 1, WIDTH // 2 + 1):
        if cells[_SHOULDERS - 1][column] == cells[_SHOULDERS][column] == "─":
            cells[_SHOULDERS - 1][column], cells[_SHOULDERS][column] = "┬", "┴"


def _turned(face: Sequence[str], step: int) -> list[str]:
    """Return a face with its features moved to one side within its frame, if there is room."""
    lines = list(face)
    for row in range(1, len(lines) - 1):
        frame = lines[row].rstrip()
        left = len(frame) - len(frame.lstrip())
        inner, rest = frame[left + 1 : -1], lines[row][len(frame) :]
        if step > 0 and inner.endswith(" "):
            inner = f" {inner[:-1]}"
        elif step < 0 and inner.startswith(" "):
            inner = f"{inner[1:]} "
        lines[row] = frame[: left + 1] + inner + frame[-1:] + rest
    return lines


def _put_arm(cells: Cells, shoulder: int, side: int, raised: float) -> None:
    """Draw an arm from a shoulder's column to the left (side -1) or the right (1)."""
    slant = "╱" if side > 0 else "╲"
    if raised < _OUT:
        _put(cells, shoulder + side, _SHOULDERS + 1, "╲" if side > 0 else "╱")
    elif raised < _SLANTED:
        for reach in (1, 2):
            _put(cells, shoulder + side * reach, _SHOULDERS, "─")
        _put(cells, shoulder + side * 3, _SHOULDERS, "●")
    elif raised < _UP:
        for reach in (1, 2, 3):
            _put(cells, shoulder + side * reach, _SHOULDERS + 1 - reach, slant)
        _put(cells, shoulder + side * 4, _SHOULDERS - 3, "●")
    else:
        elbow = WIDTH // 2 + side * 7
        for column in range(min(shoulder, elbow) + 1, max(shoulder, elbow)):
            _put(cells, column, _SHOULDERS, "─")
        _put(cells, elbow, _SHOULDERS, "╯" if side > 0 else "╰")
        for row in range(1, _SHOULDERS):
            _put(cells, elbow, row, "│")
        _put(cells, elbow, 0, "●")


def _step(value: float) -> int:
    """Return a joint's position as a step of -1, 0 or 1 characters."""
    return (value >= _SEEN) - (value <= -_SEEN)


def _add(one: float, other: float) -> float:
    return max(-1.0, min(1.0, one + other))


def _put(cells: Cells, column: int, row: int, text: str) -> None:
    """Write text into the cells, without the part that is outside."""
    for offset, character in enumerate(text):
        if 0 <= row < HEIGHT and 0 <= column + offset < WIDTH:
            cells[row][column + offset] = character
