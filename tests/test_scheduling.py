"""The tests of a file stay in one process; those of the built pages keep all of them busy."""

from pathlib import Path
from types import SimpleNamespace

from tests.scheduling import PAGES, pytest_xdist_make_scheduler

ROOT = Path(__file__).resolve().parents[1]
CELLS = [f"book/a.ipynb::Cell {k}" for k in range(6)]
UNITS = [f"tests/test_a.py::test_a[{k}]" for k in range(4)]
ON_PAGES = [f"{PAGES}::test_is_whole[book/{k}]" for k in range(20)]


class Process:
    """A process of pytest-xdist, as its scheduler sees it, that notes what it is to run."""

    def __init__(self, name):
        self.gateway = SimpleNamespace(id=name)
        self.shutting_down = False
        self.given, self.done = [], []

    def send_runtest_some(self, indices):
        self.given += indices

    def shutdown(self):
        self.shutting_down = True


def scheduler(dist):
    options = {"dist": dist, "tx": ["2*popen"], "loadscopereorder": True}
    config = SimpleNamespace(
        option=SimpleNamespace(**options), getoption=options.get, getvalue=options.get
    )
    return pytest_xdist_make_scheduler(config, None)


def shared_out(tests):
    """Let two processes, one test each in turn, run all tests; return what each has run."""
    sharing, processes = scheduler("loadfile"), [Process("one"), Process("two")]
    for process in processes:
        sharing.add_node(process)
        sharing.add_node_collection(process, tests)
    sharing.schedule()
    while any(process.given for process in processes):
        for process in processes:
            if process.given:
                test = process.given.pop(0)
                process.done.append(tests[test])
                sharing.mark_test_complete(process, test)
    return [process.done for process in processes]


def test_a_file_is_for_one_process_and_the_pages_are_for_all():
    one, two = shared_out([*ON_PAGES, *CELLS, *UNITS])
    assert one[:6] == CELLS
    assert two[:4] == UNITS
    assert sorted(one[6:] + two[4:]) == sorted(ON_PAGES)
    assert abs(len(one) - len(two)) <= 1


def test_there_are_tests_of_the_pages():
    assert (ROOT / PAGES).is_file()


def test_who_asks_for_another_way_gets_it():
    assert scheduler("load") is None
