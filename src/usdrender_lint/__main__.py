"""What happens when the program is run: `usdrender-lint` and `python -m usdrender_lint`."""

from __future__ import annotations

import sys
from collections.abc import Sequence


def main(argv: Sequence[str] | None = None) -> int:
    try:
        from .cli import run

        return run(list(sys.argv[1:] if argv is None else argv))
    except KeyboardInterrupt:  # while modules are still being imported
        return 130


if __name__ == "__main__":
    raise SystemExit(main())
