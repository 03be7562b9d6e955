"""Silverbox, an electronic Duffing circuit."""

from __future__ import annotations

import numpy as np

from .. import sources
from .record import Folder, MeasuredRecord, MeasuredSet


def load_silverbox(folder: Folder = None) -> MeasuredSet:
    """Silverbox, an electronic Duffing circuit, 610.35 Hz.

    Parameters
    ----------
    folder : path, optional
        Folder that holds ``silverbox/silverbox.npz``; searched for, or downloaded, by default.

    Returns
    -------
    MeasuredSet
        Of the multisine (samples 40650 to 127400) the first 75 % train and the last 25 % test as
        ``"multisine"``; ``"arrow"`` (samples 100 to 40575) tests beyond the amplitudes of the
        training. y: voltage in V; u: voltage in V, without its mean over the whole record, as the
        generator has no offset.

    Raises
    ------
    FileNotFoundError
        If `folder` is given and does not hold the file.
    ImportError
        If the file has to be downloaded and pooch is not installed.

    References
    ----------
    Wigren, Schoukens, "Three free data sets for development and benchmarking in nonlinear system
    identification", ECC 2013, doi:10.23919/ECC.2013.6669201.
    """
    columns = sources.read_columns("silverbox/silverbox.npz", folder, _published)
    y, u = columns["y"].astype(float), columns["u"].astype(float)
    u = u - u.mean()
    sampling_rate = 1e7 / 2**14  # Hz, the clock of the generator divided by 2^14
    start, stop = 40650, 127400
    cut = start + int(0.75 * (stop - start))

    def record(name: str, begin: int, end: int) -> MeasuredRecord:
        return MeasuredRecord(
            name=name,
            t=np.arange(end - begin) / sampling_rate,
            y=y[begin:end, None],
            u=u[begin:end, None],
            outputs=("y",),
            inputs=("u",),
        )

    return MeasuredSet(
        train=(record("train", start, cut),),
        test=(record("multisine", cut, stop), record("arrow", 100, 40575)),
    )


def _published() -> sources.Columns:
    """Input and output of the long record.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)
        u and y in V.
    """
    table = sources.read_csv(
        sources.fetch(
            "biaslab/nsi-silverbox",
            "728f07e4539d4f7da76a4778b52a756260b488ac",
            "data/Silverbox/SNLS80mV.csv",
        )
    )
    return {"u": table["V1"], "y": table["V2"]}
