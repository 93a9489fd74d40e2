"""The drawn robot: what a pose looks like."""

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from sar_tui.model.gesture import GESTURES, REST, Pose
from sar_tui.model.theme import FACES, GAZES, Theme
from sar_tui.plugins import Catalogue
from sar_tui.widgets.robot import HEIGHT, WIDTH, draw, posed, with_mouth

FOLDER = Path(__file__).parent / "snapshots"
THEMES = ("calm", "high-contrast", "playful")
POSES = {
    "at rest": REST,
    "head down": Pose(nod=1),
    "head up": Pose(nod=-1),
    "turned left": Pose(turn=-0.5),
    "turned far right": Pose(turn=1),
    "leaning in": Pose(lean=1),
    "right arm out": Pose(right_arm=0.3),
    "both arms slanted": Pose(left_arm=0.6, right_arm=0.6),
    "both arms up": Pose(left_arm=1, right_arm=1),
    "cheering": Pose(left_arm=1, right_arm=1, nod=-1, lean=1),
}
poses = st.builds(Pose, *[st.floats(-1, 1)] * 5)


def faces(theme: Theme) -> dict[str, list[str]]:
    return {name: face.splitlines() for name, face in theme.faces.items()}


def theme_sheet(theme: Theme) -> str:
    """Every face with its mouth shut and open, and then the robot in its poses, side by side."""
    drawn, speaking = faces(theme), faces(theme)["speaking"]
    open_mouthed = {
        name: with_mouth(face, theme.mouth_line, speaking) for name, face in drawn.items()
    }
    rows = [
        {name: draw(drawn[name], REST) for name in FACES[:4]},
        {f"{name}, speaks": draw(open_mouthed[name], REST) for name in FACES[:4]},
        {name: draw(drawn[name], REST) for name in FACES[4:]},
        {f"{name}, speaks": draw(open_mouthed[name], REST) for name in FACES[4:]},
        {name: draw(drawn["neutral"], pose) for name, pose in list(POSES.items())[:5]},
        {name: draw(drawn["happy"], pose) for name, pose in list(POSES.items())[5:]},
    ]
    return "\n".join(line for row in rows for line in _side_by_side(row)) + "\n"


def _side_by_side(drawings: dict[str, list[str]]) -> list[str]:
    heads = "  ".join(name.ljust(WIDTH) for name in drawings)
    lines = ("  ".join(parts) for parts in zip(*drawings.values(), strict=True))
    return [line.rstrip() for line in (heads, *lines)]


@pytest.mark.parametrize("name", THEMES)
def test_snapshots_of_every_expression_and_pose(name: str, catalogue: Catalogue) -> None:
    """``SAR_TUI_UPDATE_SNAPSHOTS=1`` draws them anew; then look at what has changed."""
    sheet, path = theme_sheet(catalogue.theme(name)), FOLDER / f"robot.{name}.txt"
    if os.environ.get("SAR_TUI_UPDATE_SNAPSHOTS"):
        path.write_text(sheet, encoding="utf-8")
    assert path.read_text(encoding="utf-8") == sheet


@pytest.mark.parametrize("name", THEMES)
@given(pose=poses, gaze=st.sampled_from(GAZES))
def test_drawings_of_all_poses_have_one_size_and_one_cell_per_character(
    name: str, pose: Pose, gaze: str, catalogue: Catalogue
) -> None:
    for face in faces(catalogue.theme(name)).values():
        drawing = draw(face, posed(pose, gaze))
        assert len(drawing) == HEIGHT
        assert all(len(line) == cell_len(line) == WIDTH for line in drawing)


@pytest.mark.parametrize("name", THEMES)
@given(pose=poses)
def test_no_pose_cuts_eyes_or_mouth(name: str, pose: Pose, catalogue: Catalogue) -> None:
    for face in faces(catalogue.theme(name)).values():
        drawing = "\n".join(draw(face, pose))
        assert all(line.strip(" │|").strip() in drawing for line in face[1:3])


@pytest.mark.parametrize("name", THEMES)
def test_every_gesture_begins_and_ends_at_rest(name: str, catalogue: Catalogue) -> None:
    theme = catalogue.theme(name)
    face = faces(theme)["neutral"]
    for gesture in GESTURES:
        way = theme.gestures[gesture]
        moments = [draw(face, way.pose_at(ms)) for ms in range(0, way.duration_ms, 66)]
        assert moments[0] == draw(face, REST), gesture
        assert any(moment != moments[0] for moment in moments), gesture
        assert draw(face, way.pose_at(way.duration_ms)) == draw(face, REST), gesture


def test_a_face_without_space_at_the_side_is_drawn_completely() -> None:
    face = ["+---+", "|o o|", "| - |", "+---+"]
    drawing = draw(face, Pose(turn=0.5))
    assert any("|o o|" in line for line in drawing)
    assert any("|  -|" in line for line in drawing)


def test_small_and_ascii_faces_have_a_matching_body() -> None:
    drawing = draw(["(o_o)"], Pose(turn=1, right_arm=0.6))
    assert "".join(drawing).isascii()
    assert "(o_o)" in drawing[4]
    assert drawing[4].index("(o_o)") == (WIDTH - 5) // 2 + 1


def test_gaze_adds_to_a_gesture_within_the_limits_of_joints() -> None:
    assert posed(Pose(turn=0.3, left_arm=0.7), "right") == Pose(turn=0.8, left_arm=0.7)
    assert posed(Pose(turn=0.8), "right").turn == 1
    assert posed(Pose(nod=0.2), "ahead") == Pose(nod=0.2)


def test_only_the_mouth_is_taken_from_another_face() -> None:
    assert with_mouth(["a", "b", "c"], 1, ["x", "y", "z"]) == ["a", "y", "c"]
    assert with_mouth(["a"], 2, ["x", "y", "z"]) == ["a"]
