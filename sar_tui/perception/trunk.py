"""The trunk during a reach, as measured by a second sensor, on the sternum."""

import math

from sar_tui.model.messages import SensorChanged
from sar_tui.model.units import MS
from sar_tui.motion.analysis import NS, Measured
from sar_tui.motion.quaternions import angle, integrate
from sar_tui.motion.rest import even
from sar_tui.motion.samples import Recording, recording
from sar_tui.perception.kept_samples import KeptSamples

_AFTER = 100 * MS
"""Time after a reach whose samples are used too."""


class Trunk:
    """The samples of a participant's trunk sensor, and what they tell of a reach.

    Nothing depends on that sensor: without it, or if it fails, the reach is measured all the same.
    """

    def __init__(self) -> None:
        self._kept = KeptSamples()
        self._has_sensor = False

    def sensor_changed(self, sensor: SensorChanged) -> None:
        """Forget samples from before the sensor was attached."""
        if sensor.state == "attached":
            self._has_sensor = True
            self._kept.clear()

    def add(self, block: bytes, keep_ns: int | None) -> None:
        """Add packed samples; while no reach is watched, forget those older than ``keep_ns`` before
        the newest.
        """
        newest = int(self._kept.add(block)["at"][-1])
        if keep_ns is not None:
            self._kept.forget_before(newest - keep_ns)

    def measures(
        self, from_ns: int, onset_ns: int | None, end_ns: int | None, hand_deg: float | None
    ) -> Measured:
        """Return the measures of the trunk, as fields; none if there never was a sensor.

        Args:
            from_ns: where the samples begin that are used.
            onset_ns: of the reach; None if none was found.
            end_ns: of the reach.
            hand_deg: excursion of the hand in it; None if it was not measured.
        """
        if not self._has_sensor:
            return {}
        excursion_deg = share = None
        if onset_ns is not None and end_ns is not None:
            samples = self._kept.all()
            inside = samples[(samples["at"] >= from_ns) & (samples["at"] < end_ns + _AFTER)]
            if len(inside) > 1:
                whole = recording(inside, from_ns)
                excursion_deg = trunk_excursion_deg(
                    whole, (onset_ns - from_ns) / NS, (end_ns - from_ns) / NS
                )
            share = compensation_share(excursion_deg, hand_deg)
        return {
            "trunk_excursion_deg": None if excursion_deg is None else round(excursion_deg, 4),
            "compensation_share": None if share is None else round(share, 4),
        }


REST_S = 1.0
"""Stillness of the trunk that gives the sensor's bias."""


def trunk_excursion_deg(recording: Recording, onset_s: float, end_s: float) -> float | None:
    """Return the largest angle of the sternum from its orientation at the onset of a reach, in
    degrees.

    It is an angle about any axis: leaning forward, to the side, and turning all count. After a
    stroke, many people move the trunk even to reach targets within arm's length ("Use of the trunk
    for reaching targets placed within and beyond the reach in adult hemiparesis", Levin et al.
    2002, Exp Brain Res). Such studies measure displacement; this is a rotation, so the figures
    cannot be compared.

    None if the recording does not cover the reach, misses more than `grid.GAP_S` of it, or has no
    rest of ``REST_S``.

    Args:
        recording: of the sensor on the sternum, with a rest, on the clock of the hand's sensor.
        onset_s, end_s: the reach, as found by the sensor on the hand.
    """
    grid = even(recording)
    if len(grid.time_s) < 2 or not grid.time_s[0] <= onset_s < end_s <= grid.time_s[-1]:
        return None
    if grid.has_hole(onset_s, end_s):
        return None
    rest, rate, _ = grid.unbiased(REST_S)
    inside = (grid.time_s >= onset_s) & (grid.time_s <= end_s)
    if not rest.whole or not inside.any():
        return None
    return math.degrees(float(angle(integrate(rate[inside], 1.0 / grid.rate_hz)).max()))


def compensation_share(trunk_deg: float | None, hand_deg: float | None) -> float | None:
    """Return the trunk's share in the turning of a reach: its excursion over the sum of its and the
    hand's, 0 to 1.

    It is defined here, to compare a person with themselves; the share that studies report is of
    displacement. The sensor on the hand turns with the trunk too, so the share stays below one half
    unless the arm hardly moves.

    None if either excursion is not known, or both are 0.
    """
    if trunk_deg is None or hand_deg is None or not trunk_deg + hand_deg:
        return None
    return trunk_deg / (trunk_deg + hand_deg)
