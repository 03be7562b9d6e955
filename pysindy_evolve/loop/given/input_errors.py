"""What a record does not know of its inputs: the noise of their sensors, and the time in between.

An input that jumps between levels is held from one sample to the next, and is recorded at best as
the mean of the values before and after each sample. A motion that follows from it is a little
quicker, by the share (omega dt)^2 / 6 at the frequency omega.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import correlate1d

from ...signals import Record
from ...signals.noise import input_noise

__all__ = ["input_error"]

HELD = 1.0 / 6.0  # of the second difference: by so much an input may differ from what was recorded


def input_error(record: Record, rng: np.random.Generator) -> np.ndarray | None:
    """Draw by what the inputs of a record may differ from those that drove the machine.

    Parameters
    ----------
    record : Record
        Made from raw data, or nothing is known of its inputs.
    rng : numpy.random.Generator
        Draws the noise.

    Returns
    -------
    ndarray of shape (n_samples, n_inputs) or None
        Units of u, after the low-pass of the record. None if there are no inputs, or no raw data.
    """
    made = record.preparation
    if made is None or made.u is None:
        return None
    noise = input_noise(made.u, made.dt, made.cutoff) * rng.standard_normal(made.u.shape)
    between = HELD * correlate1d(made.u, [1.0, -2.0, 1.0], axis=0, mode="nearest")
    return made.lowpass(noise + between)
