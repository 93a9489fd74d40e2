"""What the sensor check says, and what to do: of the sensor, of how it lies on the hand, of a test reach."""

import math
from typing import Literal, NamedTuple

from sar_tui.app.sensor_watch import ReachTest, SensorWatch
from sar_tui.framework.clock import SECOND
from sar_tui.inputs.imu import Vector
from sar_tui.motion.analysis import Finding
from sar_tui.motion.bounds import Hand

Mark = Literal["right", "wait", "wrong"]
MARKS: dict[Mark, str] = {"right": "✓", "wait": "…", "wrong": "!"}

LOOKING = 3 * SECOND
"""A sensor that has not been found by then is said to be missing."""
ENOUGH = 0.9
"""The share of the samples that a sensor should send a second, and does."""
FEW_LOST = 0.01
LARGE_BIAS_RAD_S = 0.05
"""Half of what the thesis' rule takes for movement."""

_G = 9.81
_RESTING_G = 2.0
_UPRIGHT = math.cos(math.radians(35))

FLAGS = {
    "reversed": "Wrong way out: the sensor is turned round, or it is not the {hand} hand.",
    "gap": "Samples are missing in it: try another cable or port.",
    "saturated": "It was faster than the sensor can measure: only its times are known.",
    "no_rest": "The hand did not rest before it: keep it still for two seconds first.",
    "error": "The sensor told of an error during it.",
    "cut": "It had begun before, or was not over: rest before it and after it.",
    "timed_out": "It took too long.",
    "low_rate": "The sensor sends few samples a second: its times are less exact.",
    "several": "There was more than one reach: this is the largest.",
}
"""What to beware of in a test reach, and what to do."""

NO_REACH = "No reach out and back was seen. Is the sensor on the hand that reaches?"
INVALID = {
    "samples": "Too few samples came to see a reach.",
    "gap": FLAGS["gap"],
    "rate": "The sensor sends too few samples a second to see a reach.",
}


class Fact(NamedTuple):
    """One line of what is known: whether it is as it should be, what it is about, and what it is."""

    mark: Mark
    title: str
    text: str


def facts(watch: SensorWatch) -> list[Fact]:
    """What is known of the sensor, the most important first. Without a sensor that is all there is."""
    found = [_sensor(watch)]
    if watch.attached and not watch.stalled:
        found += [_samples(watch), _rest(watch), _placing(watch)]
        if watch.trouble:
            found.append(Fact("wrong", "Trouble", watch.trouble))
    return found


def _sensor(watch: SensorWatch) -> Fact:
    if watch.attached and not watch.stalled:
        info = watch.feed.info
        serial = f", serial {info.serial}" if info and info.serial else ""
        return Fact("right", "Sensor", f"{info.model}{serial}" if info else "attached")
    if watch.state == "none" and watch.waited < LOOKING:
        return Fact("wait", "Sensor", "Looking for it …")
    why = {
        "none": f"No sensor found. {watch.told or 'Plug it in; it is found by itself.'}",
        "attached": "It is attached, but sends nothing. Unplug it, and plug it in again.",
        "unplugged": f"It was unplugged. {watch.told or 'Plug it in again.'}",
        "failed": watch.told,
        "ended": f"{watch.told or 'The recording is over.'} A session plays it from its beginning.",
    }
    return Fact("wrong", "Sensor", why[watch.state])


def _samples(watch: SensorWatch) -> Fact:
    feed, info = watch.feed, watch.feed.info
    nominal = info.rate_hz if info else 0.0
    text = f"{feed.rate_hz:.0f} a second" + (f" of {nominal:.0f}" if nominal else "")
    lost = max(0, feed.lost - watch.unmeasured)
    missing = [f"{lost} lost"] if lost else []
    missing += [f"{feed.dropped} left out"] if feed.dropped else []
    missing += [f"{watch.saturated} beyond its range"] if watch.saturated else []
    text += ", " + (", ".join(missing) or "none lost")
    if watch.too_slow:
        return Fact("wrong", "Samples", f"{text}. That is too few to see a reach.")
    if lost + feed.dropped > FEW_LOST * max(1, feed.received):
        return Fact("wrong", "Samples", f"{text}. Try another cable or port.")
    settled = watch.waited > LOOKING
    if feed.rate_hz < ENOUGH * nominal:
        return Fact("wrong", "Samples", f"{text}. It is too slow.") if settled else Fact("wait", "Samples", text)
    return Fact("right", "Samples", text)


def _rest(watch: SensorWatch) -> Fact:
    bias = watch.bias
    if watch.still_s is None:
        return Fact("wait", "At rest", "cannot be seen yet")
    if bias is None:
        return Fact("wait", "At rest", "moving" if watch.still_s == 0 else "still …")
    if math.hypot(*bias) > LARGE_BIAS_RAD_S:
        return Fact("wrong", "At rest", "still, but the bias is large: press Z")
    return Fact("right", "At rest", "still")


def _placing(watch: SensorWatch) -> Fact:
    return placing(watch.up) if watch.rate else Fact("wait", "Placing", "cannot be seen yet")


def placing(up: Vector | None) -> Fact:
    """Whether z points up, as it should while the hand lies flat, palm down; from the acceleration at rest, m/s²."""
    if up is None:
        return Fact("wait", "Placing", "cannot be seen: it measures no acceleration")
    size = math.hypot(*up)
    if abs(size - _G) > _RESTING_G:
        return Fact("wait", "Placing", "moving")
    if up[2] > _UPRIGHT * size:
        return Fact("right", "Placing", "z points up, as it should")
    if up[2] < -_UPRIGHT * size:
        return Fact("wrong", "Placing", "turned over: z points down. Lay the hand flat, palm down.")
    axis = max(range(3), key=lambda index: abs(up[index]))
    way = f"{'xyz'[axis]} points {'up' if up[axis] > 0 else 'down'}"
    lean = f"{way}, leaning" if axis == 2 else way
    return Fact("wrong", "Placing", f"{lean}. Lay the hand flat, palm down: z should point up.")


def words_of(test: ReachTest, hand: Hand) -> list[tuple[Mark, str]]:
    """What a test reach asks for, or what came of it: the numbers first, then what to beware of."""
    match test.step:
        case "rest":
            return [("wait", "Rest the hand at the start, and keep it still …")]
        case "reach":
            return [("wait", "Now reach out, come back, and rest.")]
        case "lost":
            return [("wrong", "There is no sensor to test. Plug it in, then press T.")]
    return result_words(test.finding, hand) if test.finding else []


def result_words(found: Finding, hand: Hand) -> list[tuple[Mark, str]]:
    """A reach that was looked for: its numbers, and what is wrong with it, one sentence each."""
    if found.onset_ns is None:
        return [("wrong", INVALID.get(found.invalid, NO_REACH))]
    wrong = [FLAGS.get(flag, f"It is marked: {flag.replace('_', ' ')}.").format(hand=hand) for flag in found.flags]
    said: list[tuple[Mark, str]] = [("wrong", words) for words in wrong]
    return [("wrong" if wrong else "right", _numbers(found)), *said]


def _numbers(found: Finding) -> str:
    """Reach time, its phases, and the peaks."""
    time, out, dwell, back = (_second(found, f"{name}_ms") for name in ("reach_time", "out", "dwell", "back"))
    phases = f"out {out}, dwell {dwell}, back {back}"
    fastest, returning = found.details.get("peak_extension_rad_s"), found.details.get("peak_return_rad_s")
    peaks = "peaks not known"
    if isinstance(fastest, float) and isinstance(returning, float):
        peaks = f"peaks {signed(fastest, 1)} and {signed(returning, 1)} rad/s"
    return f"Reach {time} s: {phases}; {peaks}."


def _second(found: Finding, name: str) -> str:
    value = found.details.get(name)
    return f"{value / 1000:.2f}" if isinstance(value, int | float) else "?"


def signed(value: float, digits: int) -> str:
    """A number with its sign, and never −0."""
    return f"{round(value, digits) + 0.0:+.{digits}f}".replace("-", "−")
