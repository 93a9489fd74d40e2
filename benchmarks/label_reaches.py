"""Label the reaches in the exercise recordings of ``tests/data/real-reaches`` by a rule, and write
``labels-by-rule.json`` there: ``python -m benchmarks.label_reaches``.

No detector is used. A recording holds sets of repetitions (done well, too fast, too small), with
10 s or more between them. Two passes look at different sensors:

- *turns*, from the gyroscope: the rate about the set's dominant axis is integrated to an angle,
  whose turning points, by at least 40 % of a typical swing, divide ways out from ways back. A way
  lasts while the rate exceeds 5 % of the way's largest.
- *gravity*, from the accelerometer below about 1.5 Hz: the direction of gravity as an angle from
  home towards the target. A way is where it crosses the middle between the levels before and
  after: it begins where the angle leaves the one level by more than 7 % of the way, and ends where
  it comes as near to the other.

Both passes must have a reach: they share at least half of its time. Otherwise it is doubtful,
neither found nor false. A boundary is that of the turns if gravity confirms it to 0.3 s; otherwise
it is null, and not scored. The file lists what differs, and how far either pass is from the twenty
reaches that were labelled by eye.
"""

import json
import math
import re
from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks.real_recordings import BY_EYE, BY_RULE, EXERCISES, read_exercise
from sar_tui.motion.samples import Floats, Recording

RATE_HZ = 25.0
APART_S, AROUND_S = 10.0, 3.0
MOVING_RAD_S = 0.3
SWING = 0.4
LEAST_SET = 0.2
SPEED_SHARE, DIP_S = 0.05, 0.2
NEAR = 0.07
AGREE_S = 0.3
MANNERS = ("well", "fast", "small")

Times = tuple[float, float, float, float]
"""Onset, arrival, departure and end of a reach, in s."""
Way = tuple[float, float, int]
"""Begin and end of a way, in s, and its sign: 1 out, -1 back."""


def main() -> None:
    """Label all recordings, write the file, and print a summary."""
    labels = labelled()
    BY_RULE.write_text(_lines(labels))
    for name, sets in labels["recordings"].items():
        for each in sets:
            print(name, each["manner"], len(each["reaches"]), "differ:", len(each["differences"]))
    for name, off in labels["minus_by_eye_s"].items():
        print(name, "passes minus labels by eye (median, s):", off)


def labelled() -> dict[str, Any]:
    """Return the content of the file."""
    by_eye = json.loads(BY_EYE.read_text())
    recordings, off = {}, {}
    for name in EXERCISES:
        recording = read_exercise(name)
        parts = sets_of(recording)
        if name in by_eye:
            off[name] = {
                which: compared(
                    [times for part in parts for times in find(recording, part)], by_eye[name]
                )
                for which, find in (("turns", turns), ("gravity", gravity))
            }
            continue
        recordings[name] = [
            {"manner": manner} | label_set(recording, part)
            for manner, part in zip(MANNERS, parts, strict=True)
        ]
    return {"minus_by_eye_s": off, "recordings": recordings}


def sets_of(recording: Recording) -> list[slice]:
    """Return the sets of repetitions, each with the rest around it."""
    speed = np.linalg.norm(_smoothed(recording.rate, 0.2), axis=1)
    moving = np.flatnonzero(speed > MOVING_RAD_S)
    cuts = np.flatnonzero(np.diff(moving) > APART_S * RATE_HZ)
    around = round(AROUND_S * RATE_HZ)
    parts = [
        slice(max(0, int(first) - around), int(last) + around)
        for first, last in zip(
            moving[[0, *(cuts + 1)]], moving[[*cuts, len(moving) - 1]], strict=True
        )
    ]
    turned = [float(speed[part].sum()) for part in parts]
    return [part for part, by in zip(parts, turned, strict=True) if by > LEAST_SET * max(turned)]


def label_set(recording: Recording, part: slice) -> dict[str, Any]:
    """Return the reaches of a set that both passes have, what is doubtful, and what differs."""
    by_turns, by_gravity = turns(recording, part), gravity(recording, part)
    reaches: list[list[float | None]] = []
    doubtful: list[list[float]] = []
    differences: list[dict[str, list[float]]] = []
    for one in by_turns:
        other = next((each for each in by_gravity if _shared(one, each) >= 0.5), None)
        if other is None:
            doubtful.append(_rounded(one))
            differences.append({"only turns": _rounded(one)})
            continue
        near = [abs(a - b) <= AGREE_S for a, b in zip(one, other, strict=True)]
        reaches.append([at if ok else None for at, ok in zip(_rounded(one), near, strict=True)])
        if not all(near):
            differences.append({"turns": _rounded(one), "gravity": _rounded(other)})
    for other in by_gravity:
        if all(_shared(one, other) < 0.5 for one in by_turns):
            doubtful.append(_rounded(other))
            differences.append({"only gravity": _rounded(other)})
    times = recording.time_s[part]
    return {
        "from_s": float(times[0]),
        "to_s": float(times[-1]),
        "reaches": reaches,
        "doubtful": doubtful,
        "differences": differences,
    }


# --- the two passes


def turns(recording: Recording, part: slice) -> list[Times]:
    """Return the reaches of a set from the turning points of the angle about its dominant axis."""
    rate = _smoothed(recording.rate - _bias(recording), 0.04)[part]
    time_s = recording.time_s[part]
    _, axes = np.linalg.eigh(rate.T @ rate)
    about = rate @ axes[:, -1]
    angle = np.cumsum(about) / RATE_HZ
    points = _turning_points(angle, SWING * _typical_swing(angle))
    out = math.copysign(1.0, angle[points[1]] - angle[points[0]])  # a set begins with a way out
    ways: list[Way] = []
    for before, after in pairwise(points):
        sign = round(out * math.copysign(1.0, angle[after] - angle[before]))
        speed = sign * out * about[before : after + 1]
        first, last = _around_peak(speed)
        ways.append((float(time_s[before + first]), float(time_s[before + last]), sign))
    return _reaches(ways)


def _around_peak(speed: Floats) -> tuple[int, int]:
    """Return the first and last sample of the movement that holds the largest speed."""
    peak = int(speed.argmax())
    fast = np.flatnonzero(speed > SPEED_SHARE * speed[peak])
    rests = np.flatnonzero(np.diff(fast) > DIP_S * RATE_HZ)
    starts, stops = fast[[0, *(rests + 1)]], fast[[*rests, len(fast) - 1]]
    holds = int(np.flatnonzero((starts <= peak) & (peak <= stops))[0])
    return int(starts[holds]), int(stops[holds])


def gravity(recording: Recording, part: slice) -> list[Times]:
    """Return the reaches of a set from the direction of gravity."""
    assert recording.acceleration is not None
    pulled = _smoothed(recording.acceleration, 0.1)[part]
    towards = pulled / np.linalg.norm(pulled, axis=1)[:, None]
    time_s = recording.time_s[part]
    home = towards[: round(AROUND_S * RATE_HZ) // 2].mean(axis=0)
    home /= np.linalg.norm(home)
    away = np.arccos(np.clip(towards @ home, -1.0, 1.0))
    target = towards[away > 0.8 * np.percentile(away, 95)].mean(axis=0)
    across = target - (target @ home) * home
    across /= np.linalg.norm(across)
    angle = np.unwrap(np.arctan2(towards @ across, towards @ home))
    low, high = np.percentile(angle, 10), np.percentile(angle, 90)
    crossings = _crossings(angle, low + 0.35 * (high - low), low + 0.65 * (high - low))
    ways: list[Way] = []
    for index, (at, sign) in enumerate(crossings):
        since = crossings[index - 1][0] if index else 0
        until = crossings[index + 1][0] if index + 1 < len(crossings) else len(angle)
        levels = _level(angle[since:at], late=True), _level(angle[at:until], late=False)
        ways.append((*_left_and_came(time_s, angle, (since, at, until), levels), sign))
    return _reaches(ways)


def _level(angle: Floats, *, late: bool) -> float:
    """Return the level of a plateau that a way leaves (``late``) or comes to: where the angle
    changes least, in the half next to the way.
    """
    half = angle[len(angle) // 2 :] if late else angle[: (len(angle) + 1) // 2]
    if len(half) < 3:
        return float(angle[len(angle) // 2])
    return float(half[np.abs(np.gradient(half)).argsort()[: max(3, len(half) // 3)]].mean())


def _left_and_came(
    time_s: Floats, angle: Floats, around: tuple[int, int, int], levels: tuple[float, float]
) -> tuple[float, float]:
    """Return when a way's angle left the one level, and when it came to the other."""
    since, at, until = around
    share = (angle - levels[0]) / (levels[1] - levels[0])
    while at > since and share[at] > 0.5:
        at -= 1
    near = np.flatnonzero(share[since : at + 1] <= NEAR)
    there = np.flatnonzero(share[at:until] >= 1.0 - NEAR)
    return (
        float(
            time_s[
                since + int(near[-1]) if len(near) else since + int(share[since : at + 1].argmin())
            ]
        ),
        float(time_s[at + int(there[0]) if len(there) else at + int(share[at:until].argmax())]),
    )


# --- parts of both


def _reaches(ways: list[Way]) -> list[Times]:
    """Return each way out with the way back after it."""
    return [
        (out[0], out[1], back[0], back[1])
        for out, back in pairwise(ways)
        if out[2] == 1 and back[2] == -1
    ]


def _bias(recording: Recording) -> Floats:
    """Return the mean rate in the calmest tenth of the recording's seconds."""
    size = round(RATE_HZ)
    seconds = recording.rate[: len(recording.rate) // size * size].reshape(-1, size, 3)
    calmest = seconds.std(axis=1).sum(axis=1).argsort()[: max(1, len(seconds) // 10)]
    return np.asarray(seconds[calmest].mean(axis=(0, 1)))


def _smoothed(values: Floats, spread_s: float) -> Floats:
    """Smooth each column with a Gaussian."""
    spread = spread_s * RATE_HZ
    kernel = np.exp(-0.5 * (np.arange(-round(4 * spread), round(4 * spread) + 1) / spread) ** 2)
    weight = np.convolve(np.ones(len(values)), kernel, "same")
    return np.column_stack([np.convolve(column, kernel, "same") / weight for column in values.T])


def _typical_swing(angle: Floats) -> float:
    size = round(4 * RATE_HZ)
    windows = np.lib.stride_tricks.sliding_window_view(angle, size)
    return float(np.quantile(windows.max(axis=1) - windows.min(axis=1), 0.6))


def _turning_points(angle: Floats, least: float) -> list[int]:
    """Return the extremes of an angle, each at least so far from the one before; the first and the
    last are the rest before the first way and after the last.
    """
    points, lowest, highest = [], 0, 0
    rising: bool | None = None
    for index, value in enumerate(angle.tolist()):
        lowest = index if value < angle[lowest] else lowest
        highest = index if value > angle[highest] else highest
        if rising is not False and value < angle[highest] - least:
            points.append(highest)
            rising, lowest = False, index
        elif rising is not True and value > angle[lowest] + least:
            points.append(lowest)
            rising, highest = True, index
    return [*points, highest if rising else lowest]


def _crossings(angle: Floats, low: float, high: float) -> list[tuple[int, int]]:
    """Return the samples at which an angle comes to be above ``high`` or below ``low``, with the
    sign.
    """
    found, is_out = [], bool(angle[0] > high)
    for index, value in enumerate(angle.tolist()):
        if (value < low) if is_out else (value > high):
            is_out = not is_out
            found.append((index, 1 if is_out else -1))
    return found


def _shared(one: Times, other: Times) -> float:
    """Return the time that two reaches share, as a part of the longer one."""
    shared = min(one[3], other[3]) - max(one[0], other[0])
    return shared / max(one[3] - one[0], other[3] - other[0])


def compared(found: list[Times], by_eye: list[list[float]]) -> dict[str, float]:
    """Return how many of the reaches by eye were found, and the median of each boundary's
    difference.
    """
    pairs = [
        (one, label)
        for label in by_eye
        for one in found
        if _shared(one, (label[0], label[1], label[2], label[3])) >= 0.5
    ]
    off = np.array([np.subtract(one, label) for one, label in pairs])
    names = ("onset", "arrival", "departure", "end")
    medians = zip(names, _rounded(np.median(off, axis=0).tolist()), strict=True)
    return {"found": len(pairs), "of": len(by_eye)} | dict(medians)


def _rounded(times: Any) -> list[float]:
    return [round(time, 2) for time in times]


def _lines(labels: dict[str, Any]) -> str:
    """Return JSON with a reach a line."""
    text = json.dumps(labels, indent=1)
    joined = re.sub(r"\[\s+([^\[\]{}]*?)\s+\]", lambda found: _joined(found[1]), text)
    return joined + "\n"


def _joined(values: str) -> str:
    return f"[{' '.join(values.split())}]"


if __name__ == "__main__":
    main()
