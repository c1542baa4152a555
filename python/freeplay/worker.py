"""Worker process of a sweep: python3 -m freeplay.worker STUDY FOLDER OUTSIDE. sweep() starts it."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

from . import _freeplay
from .errors import FreeplayError


def main() -> int:
    file, folder, outside = sys.argv[1:4]
    flag = _freeplay.StopFlag()


    # Runs that the process claimed and did not finish become available again.
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        _freeplay.sweep_into(Path(file), Path(folder), outside == "1", 1, flag, True)
    except FreeplayError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
