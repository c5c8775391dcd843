"""`python -m bematist`: the command line."""

import sys

from bematist.cli import main

if __name__ == "__main__":
    sys.exit(main())
