"""Makes ``table-4.1.csv`` beside this file: ``python data/make_recording.py``. See README.md."""

from pathlib import Path

import numpy as np

from sar_tui.motion.synthesis import Profile, table_4_1_recording

FILE = Path(__file__).with_name("table-4.1.csv")
SENSOR = Profile(
    noise_rad_s=0.005,
    bias_rad_s=(0.012, -0.008, 0.01),
    drift_rad_s_per_s=0.00005,
    tremor_hz=5.5,
    tremor_rad_s=0.02,
    axis=(0.15, 0.1, 0.98),
)
"""A good gyroscope, not quite straight on a hand that trembles a little."""


def main() -> None:
    """Write the file."""
    made = table_4_1_recording(rate_hz=125.0, still_s=2.0, profile=SENSOR, seed=41).recording
    assert made.acceleration is not None
    columns = np.column_stack((made.time_s, made.acceleration, made.rate))
    form = ["%.3f"] + ["%.4f"] * 3 + ["%.5f"] * 3
    np.savetxt(FILE, columns, form, delimiter=",", header="t,ax,ay,az,wx,wy,wz", comments="")


if __name__ == "__main__":
    main()
