"""What the tests of signals measure by."""

import numpy as np

DT = 0.01  # sampling time of the driven oscillator


def nrmse(found, true):
    return np.sqrt(np.mean((found - true) ** 2)) / np.std(true)
