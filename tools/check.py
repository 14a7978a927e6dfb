"""Run every check, print one summary, and fail if any of them did."""

import subprocess
import sys
import time

CHECKS = {
    "lint": ["ruff", "check", "--quiet", "."],
    "format": ["ruff", "format", "--check", "--quiet", "."],
    "types": ["mypy"],
    # Unit tests, doctests, notebooks, figures and built pages: pyproject.toml says where they are.
    "tests": ["pytest", "--quiet"],
}


def main() -> int:
    """Run the checks one after the other: the last, which is the long one, uses every core."""
    summary = []
    for name, command in CHECKS.items():
        start = time.perf_counter()
        print(f"== {name}: {' '.join(command)}", flush=True)
        code = subprocess.run([sys.executable, "-m", *command], check=False).returncode
        summary.append((name, code, time.perf_counter() - start))
    print("\n== summary")
    for name, code, seconds in summary:
        print(f"{'FAILED' if code else 'passed'}  {name:6} {seconds:6.1f} s")
    return int(any(code for _, code, _ in summary))


if __name__ == "__main__":
    sys.exit(main())
