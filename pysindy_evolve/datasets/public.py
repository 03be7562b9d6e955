"""Readers of the public sources: where each set was published and how its files name the columns.

Each function returns the columns under the names of the local files; the digest beside it is
`digest_of` the same columns there.
"""

import numpy as np

from pysindy_evolve.datasets.sources import Columns, fetch, read_csv, read_mat

EMPS_DIGEST = "29984e715af33ea53a9a7bb703766371481b2e38cf3a7ce8f18355117fef0ca6"
PENDULUM_DIGEST = "f9633765eba7265991d9508289de2b69d9922094487d2197faad36298bdcdbcf"
SILVERBOX_DIGEST = "81651def96477b645a3dab62cdca95f707832ae6a583767817c24a9151151b61"
CASCADED_TANKS_DIGEST = "03d91a3bd12e8500607eaa394506e2d7bdfd18fefc175683210828eda24b46ea"
TCLAB_DIGESTS = {
    "A": "c29b1dedb08bf881e68038d689d62e58e063915d44e6e64b1126ff3bc12b319e",
    "B": "6e23eb6b24102d5d4228b752000901ec655af613f79fff98995f45c682a0ab56",
    "E": "85c88213bc6a7588d99c425f68b84e335314261b388dbbc2eaa9ed35f5654137",
}
CART_DIGEST = "24d0d154db7fe18d8c2caaa93422b191ff3e6c184675588beeac4d2ff5df94c3"

_TCLAB_COMMITS = {
    "A": "196c74e5c50a00a6d873892e8d56b742d72dbd0b",
    "B": "f3d31fff371666f01b74813c4003385aa0d2b3be",
    "E": "f9a9d4b",
}


def emps() -> Columns:
    """Position and force of both records, from the authors' MATLAB files.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)
        t in s, q and qref in m, u_V in V, force in N, each for ``train`` and ``test``.
    """
    columns: Columns = {}
    for part, name in (("train", "DATA_EMPS"), ("test", "DATA_EMPS_PULSES")):
        variables = read_mat(
            fetch(
                "forgi86/sysid-neural-continuous",
                "956aa7ecd73061b0321c6f6098d74c9e4a7ce67a",
                f"examples/EMPS/data/{name}.mat",
            )
        )
        voltage = np.ravel(variables["vir"])
        columns |= {
            f"{part}_t": np.ravel(variables["t"]),
            f"{part}_q": np.ravel(variables["qm"]),
            f"{part}_qref": np.ravel(variables["qg"]),
            f"{part}_u_V": voltage,
            f"{part}_force": float(variables["gtau"]) * voltage,
        }
    return columns


def pendulum() -> Columns:
    """Angle over time, joined again from the six pieces that the authors cut.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)
        t in s, theta in rad, omega_given in rad/s.
    """
    variables = read_mat(
        fetch(
            "dynamicslab/MultiArm-Pendulum",
            "e99a7e13fe2adc8fc647321a156b6cb59a48a698",
            "ParameterEstimation/SinglePendulum/SinglePendulumDataForParameterEstimation.mat",
        )
    )
    times = [np.ravel(one) for part in ("Time_id", "Time_vad") for one in variables[part]]
    states = np.hstack([one for part in ("Y_id", "Y_vad") for one in variables[part]])
    return {"t": np.concatenate(times), "theta": states[0], "omega_given": states[1]}


def silverbox() -> Columns:
    """Input and output of the long record.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)
        u and y in V.
    """
    table = read_csv(
        fetch(
            "biaslab/nsi-silverbox",
            "728f07e4539d4f7da76a4778b52a756260b488ac",
            "data/Silverbox/SNLS80mV.csv",
        )
    )
    return {"u": table["V1"], "y": table["V2"]}


def cascaded_tanks() -> Columns:
    """Pump voltage and level of both records.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)
        u and y in V, each for ``est`` and ``val``.
    """
    table = read_csv(
        fetch(
            "Rafa7046/Non_Linear_Identification",
            "e5c9b006b0a2ec1650bc018a5fb38d2f4363d4c7",
            "src/data/tanque.csv",
        )
    )
    public_names = {"u_est": "uEst", "y_est": "yEst", "u_val": "uVal", "y_val": "yVal"}
    return {name: table[public_name] for name, public_name in public_names.items()}


def tclab(board: str) -> Columns:
    """Heater and temperatures of one board.

    Parameters
    ----------
    board : {"A", "B", "E"}
        The board, one commit each.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)
        Time in s, Q1 in %, T1 and T2 in °C.
    """
    table = read_csv(fetch("jckantor/TCLab", _TCLAB_COMMITS[board], "notebooks/step_test_data.csv"))
    return {name: table[name] for name in ("Time", "Q1", "T1", "T2")}


def cart() -> Columns:
    """Cart position over time at each gain.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)
        t in s and z in m, each for the gains ``025``, ``050``, ``100`` and ``200``, in tenths.
    """
    columns: Columns = {}
    for code in ("025", "050", "100", "200"):
        variables = read_mat(
            fetch(
                "Prof-Carter/book_ip",
                "7d5e476f404a7c83ac251f112998b723c586a05e",
                f"mfiles/p1c3/cdip_cart_pcont_data_kP_{code}_ref_02.mat",
            )
        )
        columns |= {f"t_{code}": np.ravel(variables["t"]), f"z_{code}": np.ravel(variables["z"])}
    return columns
