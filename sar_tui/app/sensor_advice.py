"""Texts of the sensor check: the state of the sensor, its placing on the hand, a test reach, and
advice.
"""

import math
from typing import Literal, NamedTuple

from sar_tui.app.sensor_monitor import CALIBRATING, Calibration, ReachTest, SensorWatch
from sar_tui.inputs.imu import Vector
from sar_tui.model.language import ENGLISH, Language, in_language
from sar_tui.model.units import SECOND
from sar_tui.motion.analysis import Finding
from sar_tui.motion.reach import Hand

Mark = Literal["right", "wait", "wrong"]
MARKS: dict[Mark, str] = {"right": "✓", "wait": "…", "wrong": "!"}

LOOKING = 3 * SECOND
"""A sensor that has not been found by then is reported as missing."""
ENOUGH = 0.9
"""Smallest good share of the nominal sample rate."""
FEW_LOST = 0.01
LARGE_BIAS_RAD_S = 0.05
"""Half of the threshold of the fixed-threshold detector."""

_G = 9.81
_RESTING_G = 2.0
_UPRIGHT = math.cos(math.radians(35))

FLAGS = {
    "reversed": "Wrong way out: the sensor is turned round, or it is not the {hand} hand.",
    "gap": "Samples are missing in it: try another cable, port or network.",
    "saturated": "It was faster than the sensor can measure: only its times are known.",
    "clipped": "Its fastest part is cut off by the sensor's range: only its times are known.",
    "too_far": "The hand turned farther than it can: the sensor must send rad/s, and seems to "
    "send deg/s.",
    "disagree": "Two ways to find it differ by more than 20 % in its time: begin and end it at "
    "rest.",
    "no_rest": "The hand did not rest before it: keep it still for two seconds first.",
    "error": "The sensor reported an error during it.",
    "cut": "It had begun before, or was not over: rest before it and after it.",
    "timed_out": "It took too long.",
    "low_rate": "The sensor sends few samples a second: its times are less exact.",
    "several": "There was more than one reach: this is the largest.",
    "unsure": "It may have been another movement: reach out, come back to the start, and rest.",
}
"""Problems of a test reach, and what to do, by flag."""

NO_REACH = "No reach out and back was seen. Is the sensor on the hand that reaches?"
INVALID = {
    "samples": "Too few samples came to see a reach.",
    "gap": FLAGS["gap"],
    "rate": "The sensor sends too few samples a second to see a reach.",
    "analysis": "The reach could not be measured.",
}


_SILENT = "It is attached, but sends nothing. Unplug it, and plug it in again."
_SILENT_IN_NETWORK = (
    "It is attached, but sends nothing. See that it is switched on, and in the network."
)


class Fact(NamedTuple):
    """One line of the check: whether it is right, its title, and its text."""

    mark: Mark
    title: str
    text: str


def facts(watch: SensorWatch, tr: Language = ENGLISH) -> list[Fact]:
    """Return the facts about the sensor, the most important first; without a sensor, only that."""
    found = [_sensor(watch, tr)]
    if watch.attached and not watch.stalled:
        found += [_samples(watch, tr), _rest(watch, tr)]
        if watch.feed.part == "hand":  # on the trunk a sensor may point in any direction
            found.append(_placing(watch, tr))
        if watch.trouble:
            found.append(Fact("wrong", tr("Trouble"), in_language(watch.trouble, tr)))
    return found


def worst(known: list[Fact]) -> Mark:
    """Return the worst mark: wrong before waiting, waiting before right."""
    marks = {fact.mark for fact in known}
    return "wrong" if "wrong" in marks else "wait" if "wait" in marks else "right"


def _sensor(watch: SensorWatch, tr: Language) -> Fact:
    title = tr("Sensor")
    if watch.attached and not watch.stalled:
        info = watch.feed.info
        if not info:
            return Fact("right", title, tr("attached"))
        name = _named(info.model, info.serial, tr)
        if watch.before in (None, (info.model, info.serial)):
            return Fact("right", title, name)
        other = tr("Last time it was {sensor}.", sensor=_named(*watch.before, tr))
        return Fact("wrong", title, f"{name}. {other}")
    if watch.state == "none" and watch.waited < LOOKING:
        return Fact("wait", title, tr("Looking for it …"))
    why = {
        "none": f"{tr('No sensor found.')} "
        f"{watch.detail or tr('Plug it in; it is found by itself.')}",
        "attached": tr(_SILENT if _has_cable(watch) else _SILENT_IN_NETWORK),
        "unplugged": f"{tr('It was disconnected.')} {watch.detail or tr('Plug it in again.')}",
        "failed": watch.detail,
        "ended": f"{watch.detail or tr('The recording is over.')} "
        f"{tr('A session plays it from its beginning.')}",
    }
    return Fact("wrong", title, why[watch.state])


def _has_cable(watch: SensorWatch) -> bool:
    info = watch.feed.info
    return info is None or info.source.startswith(("USB", "serial:"))


def _named(model: str, serial: str, tr: Language) -> str:
    return model + (tr(", serial {number}", number=serial) if serial else "")


def _samples(watch: SensorWatch, tr: Language) -> Fact:
    feed, info, title = watch.feed, watch.feed.info, tr("Samples")
    nominal = info.rate_hz if info else 0.0
    text = tr("{count} a second", count=f"{feed.rate_hz:.0f}")
    if nominal:
        text = tr(
            "{count} a second of {nominal}", count=f"{feed.rate_hz:.0f}", nominal=f"{nominal:.0f}"
        )
    lost = max(0, feed.lost - watch.unmeasured)
    missing = [tr("{count} lost", count=lost)] if lost else []
    missing += [tr("{count} left out", count=feed.dropped)] if feed.dropped else []
    missing += [tr("{count} beyond its range", count=watch.saturated)] if watch.saturated else []
    text += ", " + (", ".join(missing) or tr("none lost"))
    if watch.too_slow:
        return Fact("wrong", title, f"{text}. {tr('That is too few to see a reach.')}")
    if lost + feed.dropped > FEW_LOST * max(1, feed.received):
        return Fact("wrong", title, f"{text}. {tr('Try another cable, port or network.')}")
    if feed.rate_hz >= ENOUGH * nominal:
        return Fact("right", title, text)
    settled = watch.waited > LOOKING
    return (
        Fact("wrong", title, f"{text}. {tr('It is too slow.')}")
        if settled
        else Fact("wait", title, text)
    )


def _rest(watch: SensorWatch, tr: Language) -> Fact:
    title, bias = tr("At rest"), watch.bias
    if watch.still_s is None:
        return Fact("wait", title, tr("cannot be seen yet"))
    if bias is None:
        return Fact("wait", title, tr("moving") if watch.still_s == 0 else tr("still …"))
    if math.hypot(*bias) > LARGE_BIAS_RAD_S:
        large = tr("still, but the bias is large")
        if not watch.keeps_bias:
            large = tr("still, but the bias is large: press Z")
        return Fact("wrong", title, large)
    return Fact("right", title, tr("still"))


def _placing(watch: SensorWatch, tr: Language) -> Fact:
    return (
        placing(watch.up, tr)
        if watch.rate
        else Fact("wait", tr("Placing"), tr("cannot be seen yet"))
    )


def placing(up: Vector | None, tr: Language = ENGLISH) -> Fact:
    """Return the fact about z, which should point up while the hand lies flat; ``up``: acceleration
    at rest, m/s².
    """
    title = tr("Placing")
    if up is None:
        return Fact("wait", title, tr("cannot be seen: it measures no acceleration"))
    size = math.hypot(*up)
    if abs(size - _G) > _RESTING_G:
        return Fact("wait", title, tr("moving"))
    if up[2] > _UPRIGHT * size:
        return Fact("right", title, tr("z points up, as it should"))
    if up[2] < -_UPRIGHT * size:
        return Fact("wrong", title, tr("turned over: z points down. Lay the hand flat, palm down."))
    axis = max(range(3), key=lambda index: abs(up[index]))
    way = (
        tr("{axis} points up", axis="xyz"[axis])
        if up[axis] > 0
        else tr("{axis} points down", axis="xyz"[axis])
    )
    lean = tr("{way}, leaning", way=way) if axis == 2 else way
    return Fact("wrong", title, f"{lean}. {tr('Lay the hand flat, palm down: z should point up.')}")


def reach_test_text(test: ReachTest, hand: Hand, tr: Language = ENGLISH) -> list[tuple[Mark, str]]:
    """Return what a test reach asks for, or its result: the numbers first, then the problems."""
    match test.step:
        case "rest":
            return [("wait", tr("Rest the hand at the start, and keep it still …"))]
        case "reach":
            return [("wait", tr("Now reach out, come back, and rest."))]
        case "lost":
            return [("wrong", tr("There is no sensor to test. Plug it in, and try again."))]
    return finding_text(test.finding, hand, tr) if test.finding else []


def calibrated_text(made: Calibration, who: str, tr: Language = ENGLISH) -> str:
    """Return the result of a calibration, and how to keep or forget it."""
    angles = ", ".join(f"{degrees:.0f}°" for degrees in made.turned_deg)
    turned = tr("The reaches turned the hand by {turned}.", turned=angles)
    kept = tr(
        "From {least}° on it is a reach. Enter keeps that for {who} and begins, Esc forgets it."
    )
    return f"{turned} {kept.format(least=f'{made.least_turn_deg:.0f}', who=who)}"


def calibration_text(
    made: Calibration, test: ReachTest, hand: Hand, tr: Language = ENGLISH
) -> list[tuple[Mark, str]]:
    """Return what a calibration asks for: first why the last reach was not used."""
    said: list[tuple[Mark, str]] = []
    if made.refused:
        said = finding_text(made.refused, hand, tr)[-1:]
    elif made.turned_deg:
        turned = ", ".join(f"{degrees:.0f}°" for degrees in made.turned_deg)
        said = [("right", tr("Turned so far: {turned}.", turned=turned))]
    number = tr("Reach {number} of {count}.", number=len(made.turned_deg) + 1, count=CALIBRATING)
    asked = reach_test_text(test, hand, tr)
    return [*said, *((mark, f"{number} {text}") for mark, text in asked)]


def finding_text(found: Finding, hand: Hand, tr: Language = ENGLISH) -> list[tuple[Mark, str]]:
    """Return the numbers of a finding, and its problems in a sentence each."""
    if found.onset_ns is None:
        without = FLAGS["too_far"] if "too_far" in found.flags else NO_REACH
        return [("wrong", tr(INVALID.get(found.invalid, without)))]
    said: list[tuple[Mark, str]] = [("wrong", _flag(flag, hand, tr)) for flag in found.flags]
    return [("wrong" if said else "right", _numbers(found, tr)), *said]


def _flag(flag: str, hand: Hand, tr: Language) -> str:
    if flag not in FLAGS:
        return tr("It is marked: {flag}.", flag=flag.replace("_", " "))
    return tr(FLAGS[flag], hand=tr("left") if hand == "left" else tr("right"))


def _numbers(found: Finding, tr: Language) -> str:
    """Return reach time, phases and peaks in a sentence."""
    fastest, returning = (
        found.details.get("peak_extension_rad_s"),
        found.details.get("peak_return_rad_s"),
    )
    peaks = tr("peaks not known")
    if isinstance(fastest, float) and isinstance(returning, float):
        peaks = tr(
            "peaks {out} and {back} rad/s", out=signed(fastest, 1), back=signed(returning, 1)
        )
    return tr(
        "Reach {time} s: out {out}, dwell {dwell}, back {back}; {peaks}.",
        time=_second(found, "reach_time_ms"),
        out=_second(found, "out_ms"),
        dwell=_second(found, "dwell_ms"),
        back=_second(found, "back_ms"),
        peaks=peaks,
    )


def _second(found: Finding, name: str) -> str:
    value = found.details.get(name)
    return f"{value / 1000:.2f}" if isinstance(value, int | float) else "?"


def signed(value: float, digits: int) -> str:
    """Return a number with its sign, never −0."""
    return f"{round(value, digits) + 0.0:+.{digits}f}".replace("-", "−")
