"""See that the tests of the built pages have a browser: find one, or install it where one may."""

import os
import shutil
import subprocess
import sys

from tests.browser import find_browser

# The pages name no font of their own, so one family with Greek and mathematical signs is enough.
PACKAGES = ["chromium", "fonts-dejavu-core"]


def as_root() -> list[str] | None:
    """Return what runs a command as root, or None where that would ask for a password."""
    if not shutil.which("apt-get"):
        return None
    if os.geteuid() == 0:
        return []
    sudo = ["sudo", "-n"]
    if (
        shutil.which("sudo")
        and subprocess.run([*sudo, "true"], capture_output=True, check=False).returncode == 0
    ):
        return sudo
    return None


def install(root: list[str]) -> None:
    """Install the browser with Debian's tool."""
    quiet = [*root, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq"]
    subprocess.run([*quiet, "update"], check=True)
    # Only the last lines of what apt-get says are of use, and only if it failed.
    run = subprocess.run(
        [*quiet, "install", "-y", "--no-install-recommends", *PACKAGES],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
    )  # fmt: skip
    if run.returncode:
        print(*run.stdout.splitlines()[-10:], sep="\n", file=sys.stderr)


def main() -> int:
    """Find or install a browser; a missing one fails where CI is set."""
    if not find_browser() and (root := as_root()) is not None:
        print("Installing a browser for the tests of the pages:", *PACKAGES)
        install(root)
    if find_browser():
        return 0
    print(
        "No browser: install Chromium or Chrome, else the tests of the built pages are skipped.",
        file=sys.stderr,
    )
    return 1 if os.environ.get("CI") else 0


if __name__ == "__main__":
    sys.exit(main())
