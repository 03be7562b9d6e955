"""Loaders of records measured on real hardware, each with the split it is judged on.

Every loader takes ``folder``, the folder that holds one subfolder per set; None searches this
machine and then downloads, see `pysindy_evolve.datasets.sources.read_columns`. What comes back is
raw: nothing is filtered, and nothing but the stated input mean is removed.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from pysindy_evolve.datasets import public
from pysindy_evolve.datasets.sources import read_columns

Folder = str | os.PathLike[str] | None


@dataclass(frozen=True, eq=False)
class MeasuredRecord:
    """One record as it was measured.

    Parameters
    ----------
    name : str
        Name of the record inside its set.
    t : ndarray of shape (n_samples,)
        Time in s.
    y : ndarray of shape (n_samples, n_outputs)
        Measured outputs, in the units that the loader states.
    u : ndarray of shape (n_samples, n_inputs) or None
        Measured inputs, in the units that the loader states.
    outputs : tuple of str
        Names of the columns of ``y``.
    inputs : tuple of str
        Names of the columns of ``u``.
    extras : mapping of str to ndarray of shape (n_samples,)
        Other columns of the source.
    constants : mapping of str to float
        What is known about the rig of this record.
    """

    name: str
    t: np.ndarray
    y: np.ndarray
    u: np.ndarray | None = None
    outputs: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    extras: Mapping[str, np.ndarray] = field(default_factory=lambda: MappingProxyType({}))
    constants: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True, eq=False)
class MeasuredSet:
    """Records to fit on and records to judge on.

    Parameters
    ----------
    train : tuple of MeasuredRecord
        Records for fitting.
    test : tuple of MeasuredRecord
        Records for judging, of no influence on any choice.
    """

    train: tuple[MeasuredRecord, ...]
    test: tuple[MeasuredRecord, ...]

    def __getitem__(self, name: str) -> MeasuredRecord:
        """Return the record of that name."""
        records = {record.name: record for record in (*self.train, *self.test)}
        if name not in records:
            raise KeyError(f"records must be one of {sorted(records)}; got {name!r}.")
        return records[name]


def load_emps(folder: Folder = None) -> MeasuredSet:
    """Electro-mechanical positioning system: motor force to position of a linear axis, 1 kHz.

    Parameters
    ----------
    folder : path, optional
        Folder of measured sets.

    Returns
    -------
    MeasuredSet
        Train: ``"train"``; test: ``"pulses"``, with force pulses on the same trajectory. y:
        position q in m; u: motor force F in N; extras: reference qref in m, controller output
        u_V in V.

    References
    ----------
    Janot, Gautier, Brunot, "Data set and reference models of EMPS", Nonlinear System
    Identification Benchmarks, 2019.
    """
    columns = read_columns("emps/emps.npz", folder, public.emps, public.EMPS_DIGEST)

    def record(name: str, part: str) -> MeasuredRecord:
        return MeasuredRecord(
            name=name,
            t=columns[f"{part}_t"],
            y=columns[f"{part}_q"][:, None],
            u=columns[f"{part}_force"][:, None],
            outputs=("q",),
            inputs=("F",),
            extras={"qref": columns[f"{part}_qref"], "u_V": columns[f"{part}_u_V"]},
        )

    return MeasuredSet(train=(record("train", "train"),), test=(record("pulses", "test"),))


def load_pendulum(folder: Folder = None) -> MeasuredSet:
    """Single pendulum in free swing, its cart clamped, 1 kHz.

    Parameters
    ----------
    folder : path, optional
        Folder of measured sets.

    Returns
    -------
    MeasuredSet
        One record, cut: train ``"first"`` 60 %, test ``"rest"``. y: angle theta in rad, pi hangs
        down, in steps of 1.57e-4 rad; no input; extras: the authors' filtered velocity omega_given
        in rad/s, which lags.

    References
    ----------
    Kaheman et al., "The experimental multi-arm pendulum on a cart", arXiv 2205.06231.
    """
    columns = read_columns(
        "pendulum_multiarm/single.npz", folder, public.pendulum, public.PENDULUM_DIGEST
    )
    cut = int(0.6 * columns["t"].size)

    def record(name: str, part: slice) -> MeasuredRecord:
        return MeasuredRecord(
            name=name,
            t=columns["t"][part],
            y=columns["theta"][part, None],
            outputs=("theta",),
            extras={"omega_given": columns["omega_given"][part]},
        )

    first, rest = record("first", slice(None, cut)), record("rest", slice(cut, None))
    return MeasuredSet(train=(first,), test=(rest,))


def load_silverbox(folder: Folder = None) -> MeasuredSet:
    """Silverbox, an electronic Duffing circuit, 610.35 Hz.

    Parameters
    ----------
    folder : path, optional
        Folder of measured sets.

    Returns
    -------
    MeasuredSet
        Of the multisine (samples 40650 to 127400) the first 75 % train and the last 25 % test as
        ``"multisine"``; ``"arrow"`` (samples 100 to 40575) tests beyond the amplitudes of the
        training. y: voltage in V; u: voltage in V, the mean of the whole record removed, as the
        generator has none.

    References
    ----------
    Wigren, Schoukens, "Three free data sets for development and benchmarking in nonlinear system
    identification", ECC 2013, doi:10.23919/ECC.2013.6669201.
    """
    columns = read_columns(
        "silverbox/silverbox.npz", folder, public.silverbox, public.SILVERBOX_DIGEST
    )
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


def load_ball_drops(folder: Folder = None) -> MeasuredSet:
    """Eleven balls dropped twice from a bridge, filmed at 15 Hz.

    Parameters
    ----------
    folder : path, optional
        Folder of measured sets. The public source is a spreadsheet, which is not downloaded.

    Returns
    -------
    MeasuredSet
        Train: the first drop of each ball, test: the second, named ``"Golf Ball, drop 1"``. y:
        height h in m, in steps of about 0.028 m; no input; extras: the authors' velocity v_given
        in m/s; constants: mass in kg, circumference in m (not known for the volleyball). The last
        time step can be irregular.

    References
    ----------
    de Silva, Higdon, Brunton, Kutz, "Discovery of physics from data", Frontiers in Artificial
    Intelligence 3:25, 2020, doi:10.3389/frai.2020.00025.
    """
    columns = read_columns("ball_drops/ball_drops.csv", folder)
    balls = read_columns("ball_drops/balls.csv", folder)

    known = {
        str(name): {"mass": float(mass), "circumference": float(circumference)}
        for name, mass, circumference in zip(
            balls["ball"], balls["mass_kg"], balls["circumference_m"], strict=True
        )
    }

    def record(name: str, drop: int) -> MeasuredRecord:
        rows = (columns["ball"] == name) & (columns["drop"] == drop)
        return MeasuredRecord(
            name=f"{name}, drop {drop}",
            t=columns["t"][rows],
            y=columns["h"][rows, None],
            outputs=("h",),
            extras={"v_given": columns["v_given"][rows]},
            constants=known.get(name, {}),
        )

    names = [str(name) for name in np.unique(columns["ball"])]
    return MeasuredSet(
        train=tuple(record(name, 1) for name in names),
        test=tuple(record(name, 2) for name in names),
    )


def load_mr_damper(folder: Folder = None) -> MeasuredSet:
    """Magnetorheological damper on a shaking table, sinusoidal displacement, 100 Hz.

    Parameters
    ----------
    folder : path, optional
        Folder of measured sets. The public source does not name its columns and is not downloaded.

    Returns
    -------
    MeasuredSet
        Ten records ``"1"`` to ``"10"`` of decreasing amplitude: the odd ones train, the even ones
        test. y: force F in N, with the constant offset of the load cell (about 132 N); u:
        displacement x in mm.

    References
    ----------
    Labcontrol, UTFPR, Shaking table with MR damper, doi:10.5281/zenodo.4445334.
    """
    columns = read_columns("mr_damper_labcontrol/mr_labcontrol.npz", folder)

    def record(number: int) -> MeasuredRecord:
        force = columns[f"F_{number}"]
        return MeasuredRecord(
            name=str(number),
            t=np.arange(force.size) / float(columns["fs"]),
            y=force[:, None],
            u=columns[f"x_{number}"][:, None],
            outputs=("F",),
            inputs=("x",),
        )

    return MeasuredSet(
        train=tuple(record(number) for number in range(1, 11, 2)),
        test=tuple(record(number) for number in range(2, 11, 2)),
    )


def load_cascaded_tanks(folder: Folder = None) -> MeasuredSet:
    """Two cascaded tanks that can overflow: pump voltage to lower level, every 4 s.

    Parameters
    ----------
    folder : path, optional
        Folder of measured sets.

    Returns
    -------
    MeasuredSet
        Train: ``"estimation"``, test: ``"validation"``. y: lower level h in V of its sensor, which
        clips at 10 V; u: pump voltage in V. The level of the upper tank is not measured.

    References
    ----------
    Schoukens, Noël, "Three benchmarks addressing open challenges in nonlinear system
    identification", IFAC-PapersOnLine 50, 2017, doi:10.1016/j.ifacol.2017.08.071.
    """
    columns = read_columns(
        "cascaded_tanks/tanks.csv", folder, public.cascaded_tanks, public.CASCADED_TANKS_DIGEST
    )

    def record(name: str, part: str) -> MeasuredRecord:
        level = columns[f"y_{part}"]
        return MeasuredRecord(
            name=name,
            t=4.0 * np.arange(level.size),
            y=level[:, None],
            u=columns[f"u_{part}"][:, None],
            outputs=("h",),
            inputs=("u",),
        )

    return MeasuredSet(train=(record("estimation", "est"),), test=(record("validation", "val"),))


def load_tclab(folder: Folder = None) -> MeasuredSet:
    """Heater board with two heaters and two sensors, one step of the first heater, about 1 Hz.

    Parameters
    ----------
    folder : path, optional
        Folder of measured sets.

    Returns
    -------
    MeasuredSet
        Three boards: ``"B"`` trains, ``"E"`` and ``"A"`` test. y: temperatures T1, T2 in °C, in
        steps of 0.32 °C; u: first heater Q1 in %. The heater of board A has another power, so its
        gain must be fitted again; board E has an outlier in T2.

    References
    ----------
    Kantor, TCLab: temperature control laboratory, https://github.com/jckantor/TCLab.
    """

    def record(name: str) -> MeasuredRecord:
        columns = read_columns(
            f"tclab/rec_{name}.csv",
            folder,
            lambda: public.tclab(name),
            public.TCLAB_DIGESTS[name],
        )
        return MeasuredRecord(
            name=name,
            t=columns["Time"],
            y=np.column_stack([columns["T1"], columns["T2"]]),
            u=columns["Q1"][:, None],
            outputs=("T1", "T2"),
            inputs=("Q1",),
        )

    return MeasuredSet(train=(record("B"),), test=(record("E"), record("A")))


def load_cart(folder: Folder = None) -> MeasuredSet:
    """Cart under proportional position control at four gains, 1 kHz: nothing visible is missing.

    Parameters
    ----------
    folder : path, optional
        Folder of measured sets.

    Returns
    -------
    MeasuredSet
        Gains ``"kP=2.5"``, ``"kP=5"`` and ``"kP=10"`` train, ``"kP=20"`` tests. y: position z in
        m; u: the control signal kP (0.2 m - z), which is zero until the control starts at 1 s.

    References
    ----------
    Records of M. Kawata's book on inverted pendulums, https://github.com/Prof-Carter/book_ip.
    """
    columns = read_columns("cart_pcontrol/cart.npz", folder, public.cart, public.CART_DIGEST)

    def record(code: str) -> MeasuredRecord:
        gain = int(code) / 10
        t, z = columns[f"t_{code}"], columns[f"z_{code}"]
        return MeasuredRecord(
            name=f"kP={gain:g}",
            t=t,
            y=z[:, None],
            u=np.where(t >= 1.0, gain * (0.2 - z), 0.0)[:, None],
            outputs=("z",),
            inputs=("u",),
            constants={"kP": gain},
        )

    return MeasuredSet(
        train=tuple(record(code) for code in ("025", "050", "100")), test=(record("200"),)
    )
