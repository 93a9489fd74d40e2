"""The trunk during a reach, as measured by a second sensor, on the sternum."""

from sar_tui.model.messages import SensorChanged
from sar_tui.model.units import MS
from sar_tui.motion.analysis import NS, Measured
from sar_tui.motion.samples import recording
from sar_tui.motion.trunk import compensation_share, trunk_excursion_deg
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
