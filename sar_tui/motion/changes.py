"""Changes of a signal of few values, such as a mask."""

from typing import Any

import numpy as np
import numpy.typing as npt


def changes(values: npt.NDArray[Any]) -> npt.NDArray[np.intp]:
    """Return the indices at which a signal changes its value; before its start and after its end it
    counts as 0.

    Of a mask, they are the first index of each run of True and the first one after it, in turn.

    Args:
        values: shape (n,).
    """
    padded = np.zeros(len(values) + 2, values.dtype)
    padded[1:-1] = values
    found: npt.NDArray[np.intp] = (padded[1:] != padded[:-1]).nonzero()[0]
    return found
