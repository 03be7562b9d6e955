"""The command line: a demonstration, equations from a CSV file, a declared model corrected by one.

The command `paper` reproduces the tables and figures of the paper.

Wrong arguments or files end with exit code 2 and one line on stderr, an interrupt with 130.
Results go to stdout, progress and warnings to stderr.

================  ========================================================
what runs
commands          the commands demo, fit and loop
reproduction      the command paper
what is typed
options           the flags of each command, with their checks
readers           convert the text after a flag into a value, or refuse it
help_texts        the text that --help prints, with examples to copy
input and output
records           records from named columns of CSV files
output            what the commands print and save
================  ========================================================
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Sequence
from typing import Any

from ..threads import one_thread
from .commands import demo, fit, loop
from .options import PROGRAM, make_parser
from .output import complain
from .reproduction import paper

__all__ = ["main"]

FAILED, INTERRUPTED = 2, 130  # 130 is 128 and the number of SIGINT, as shells have it


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments : sequence of str, optional
        Arguments after the name of the program; by default those of the process.

    Returns
    -------
    int
        Exit code: 0; 2 after an error in arguments or files; 130 after an interrupt.
    """
    commands = {"demo": demo, "fit": fit, "loop": loop, "paper": paper}
    given = make_parser(commands).parse_args(arguments)
    with warnings.catch_warnings():
        warnings.showwarning = _show_warning
        try:
            with one_thread():
                finished = given.run(given)
        except KeyboardInterrupt:
            complain(f"{PROGRAM}: interrupted; nothing was found yet, or not written yet.")
            return INTERRUPTED
        except BrokenPipeError:  # the reader of the pipe, such as `head`, has ended
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        except (OSError, ValueError, TypeError, ImportError) as error:
            if given.traceback:
                raise
            complain(f"{PROGRAM} {given.command}: error: {_message(error)}")
            return FAILED
    if not finished:
        complain(f"{PROGRAM}: interrupted; what is printed was found before that.")
    return 0 if finished else INTERRUPTED


def _message(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename is not None:
        return (
            f"FILE must be one that can be opened; got {os.fspath(error.filename)!r} "
            f"({error.strerror}). Check the path."
        )
    return str(error)


def _show_warning(message: Any, *_: Any, **__: Any) -> None:
    complain(f"{PROGRAM}: warning: {message}")
