"""The command line, as `python -m supple`."""

import sys

from ._core import main

if __name__ == "__main__":
    sys.exit(main())
