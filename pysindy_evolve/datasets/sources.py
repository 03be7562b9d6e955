"""Where a measured file comes from: a folder on this machine, or its public source.

Public files and those in a local folder differ in format. So a download is checked by a digest of
the columns that were read from it, which is the same for both.
"""

import hashlib
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

Columns = dict[str, np.ndarray]

ENVIRONMENT_VARIABLE = "PYSINDY_EVOLVE_DATA"
_RAW = "https://raw.githubusercontent.com"

# `digest_of` the published columns of each file, which a download must match.
DIGESTS = {
    "cart_pcontrol/cart.npz": "24d0d154db7fe18d8c2caaa93422b191ff3e6c184675588beeac4d2ff5df94c3",
    "cascaded_tanks/tanks.csv": "03d91a3bd12e8500607eaa394506e2d7bdfd18fefc175683210828eda24b46ea",
    "emps/emps.npz": "29984e715af33ea53a9a7bb703766371481b2e38cf3a7ce8f18355117fef0ca6",
    "pendulum_multiarm/single.npz": (
        "f9633765eba7265991d9508289de2b69d9922094487d2197faad36298bdcdbcf"
    ),
    "silverbox/silverbox.npz": "81651def96477b645a3dab62cdca95f707832ae6a583767817c24a9151151b61",
    "tclab/rec_A.csv": "c29b1dedb08bf881e68038d689d62e58e063915d44e6e64b1126ff3bc12b319e",
    "tclab/rec_B.csv": "6e23eb6b24102d5d4228b752000901ec655af613f79fff98995f45c682a0ab56",
    "tclab/rec_E.csv": "85c88213bc6a7588d99c425f68b84e335314261b388dbbc2eaa9ed35f5654137",
}


def read_columns(
    file: str, folder: str | os.PathLike[str] | None, public: Callable[[], Columns] | None = None
) -> Columns:
    """Columns of one measured file, from a folder or else from its public source.

    Parameters
    ----------
    file : str
        Path inside the folder of measured sets, for example ``"set/record.npz"``.
    folder : path or None
        Folder of measured sets. None looks at the environment variable PYSINDY_EVOLVE_DATA, then
        for ``../shared/data`` beside the working directory and beside the source tree, then
        downloads.
    public : callable, optional
        Downloads and reads the public source, whose columns must have the digest that `DIGESTS`
        gives for the file. None if it has a format that numpy and scipy cannot read.

    Returns
    -------
    dict of str to ndarray
        The columns by name.

    Raises
    ------
    FileNotFoundError
        If the file is in no folder and has no public source that can be read.
    ValueError
        If the public source no longer holds the published values.
    """
    path = locate(file, folder)
    if path is not None:
        return _read(path)
    if public is None:
        raise FileNotFoundError(
            f"load(folder=...) must name a folder that holds {file}; got None, and neither "
            f"{ENVIRONMENT_VARIABLE} nor ../shared/data has it. Its public source has a format "
            "that cannot be read here: pass the folder of the converted records."
        )
    columns = public()
    if digest_of(columns) != DIGESTS[file]:
        raise ValueError(
            f"load(folder=...) must find the published content of {file}; got a download with "
            "other numbers. Delete it from the cache of pooch and try again, or pass a folder "
            "that holds the file."
        )
    return columns


def locate(file: str, folder: str | os.PathLike[str] | None) -> Path | None:
    """Path of a measured file on this machine, or None if it has to be downloaded.

    Parameters
    ----------
    file : str
        Path inside the folder of measured sets.
    folder : path or None
        Folder of measured sets; a folder that is given must hold the file.

    Returns
    -------
    Path or None
        The file.

    Raises
    ------
    FileNotFoundError
        If ``folder`` is given and does not hold the file.
    """
    if folder is not None:
        path = Path(folder) / file
        if not path.is_file():
            raise FileNotFoundError(
                f"load(folder=...) must name a folder that holds {file}; got {str(folder)!r}. "
                "Pass the folder above the one of the set, or None to search and download."
            )
        return path
    beside_sources = Path(__file__).resolve().parents[3]
    folders = [Path.cwd().parent / "shared" / "data", beside_sources / "shared" / "data"]
    if os.environ.get(ENVIRONMENT_VARIABLE):
        folders.insert(0, Path(os.environ[ENVIRONMENT_VARIABLE]))
    return next((base / file for base in folders if (base / file).is_file()), None)


def fetch(repository: str, commit: str, path: str) -> Path:
    """Download one file of a public repository, or take it from the cache.

    Parameters
    ----------
    repository : str
        Owner and name on GitHub.
    commit : str
        The commit, so that the content never changes.
    path : str
        Path inside the repository.

    Returns
    -------
    Path
        The file in the cache.

    Raises
    ------
    ImportError
        If pooch is not installed.
    """
    try:
        import pooch
    except ImportError as error:
        raise ImportError(
            "Downloading a measured set needs pooch. "
            'Install it with: pip install "pysindy-evolve[data]"'
        ) from error
    name = "-".join([repository.replace("/", "-"), commit[:7], Path(path).name])
    # No known_hash: read_columns checks the content.
    return Path(
        pooch.retrieve(
            f"{_RAW}/{repository}/{commit}/{path}",
            known_hash=None,
            fname=name,
            path=pooch.os_cache("pysindy-evolve"),
        )
    )


def read_mat(path: Path) -> dict[str, Any]:
    """Variables of a MATLAB file, with singleton dimensions squeezed.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    dict
        Arrays by variable name.
    """
    from scipy.io import loadmat

    return dict(loadmat(path, squeeze_me=True))


def read_csv(path: Path) -> Columns:
    """Columns of a comma-separated file whose first line names them.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)
        The columns by name; numbers as float, the rest as text.
    """
    table = np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8")
    names = table.dtype.names or ()
    return {
        name: table[name] if table[name].dtype.kind == "U" else table[name].astype(float)
        for name in names
    }


def digest_of(columns: Mapping[str, np.ndarray]) -> str:
    """Digest of named columns, the same for every file format that holds them.

    Parameters
    ----------
    columns : mapping of str to ndarray
        The columns by name.

    Returns
    -------
    str
        Hexadecimal SHA-256 of names, shapes and values in single precision, the least precision
        of all sources.
    """
    total = hashlib.sha256()
    for name in sorted(columns):
        values = np.asarray(columns[name], dtype="<f4") + np.float32(0.0)  # -0.0 becomes 0.0
        total.update(f"{name}{values.shape}".encode())
        total.update(values.tobytes())
    return total.hexdigest()


def _read(path: Path) -> Columns:
    """Columns of a local file, by its suffix."""
    if path.suffix == ".csv":
        return read_csv(path)
    with np.load(path, allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}
