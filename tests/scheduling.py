"""How pytest-xdist shares out the tests: a file to one process, the built pages to all of them."""

import pytest
from xdist.remote import Producer
from xdist.scheduler import LoadFileScheduling

PAGES = "tests/test_pages.py"


class LoadPages(LoadFileScheduling):
    """Keep the tests of a file together, but let each test of the built pages stand alone.

    pytest-xdist gives out the largest units first: the pages come last, one by one, to whichever
    process is free, so that all end together however many pages the book has.
    """

    def _split_scope(self, nodeid: str) -> str:
        """Name the unit that a test belongs to."""
        file = super()._split_scope(nodeid)
        return nodeid if file == PAGES else file


def pytest_xdist_make_scheduler(
    config: pytest.Config, log: Producer | None
) -> LoadFileScheduling | None:
    """Take the place of `--dist loadfile`, and of no other."""
    return LoadPages(config, log) if config.getoption("dist") == "loadfile" else None
