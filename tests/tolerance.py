"""How nbval compares a number that a notebook printed with the one that it prints now.

Words must be equal, integers exact and floats close. A number right after the sign "≈" is one that
a tie in the Delaunay triangulation decides, such as a number of steps or a minimum quality: it may
differ by much more.
"""

import math
import re

import pytest

RTOL = 1e-5  # books print four to six digits; a changed fourth one is a changed result
ATOL = 1e-9  # what is zero up to rounding may have any digits
TIES_RTOL = 0.5  # a factor of two: where a processor rounds otherwise, ties fall otherwise
TIES_ATOL = 0.05  # for qualities, which are small and lie between 0 and 1

NUMBER = re.compile(
    r"""(?:(?P<ties>≈)\s*|(?<!\w))                 # else not within a name, such as eno2
    (?P<value>[-+−]?
        (?:(?:[0-9]{1,3}(?:,[0-9]{3})+(?![0-9])|[0-9]+)\.?[0-9]*  # 82,100 or 3 or 3.14 or 3.
          |\.[0-9]+)
        (?:[eE][-+]?[0-9]+)?)""",
    re.VERBOSE,
)


def numbers_and_words(text: str) -> list[str]:
    """Split a text at its blanks and at its numbers, each of which keeps the sign "≈" before it."""
    parts: list[str] = []
    end = 0
    for number in NUMBER.finditer(text):
        parts += [*text[end : number.start()].split(), "".join(number.group().split())]
        end = number.end()
    return [*parts, *text[end:].split()]


def same_part(old: str, new: str) -> bool:
    """Compare two words or two numbers."""
    first, second = NUMBER.fullmatch(old), NUMBER.fullmatch(new)
    if not first or not second or bool(first["ties"]) != bool(second["ties"]):
        return old == new
    a, b = (float(number["value"].replace(",", "").replace("−", "-")) for number in (first, second))
    if first["ties"]:
        return math.isclose(a, b, rel_tol=TIES_RTOL, abs_tol=TIES_ATOL)
    if not re.search(r"\.[0-9]|[eE]", old + " " + new):
        return a == b
    return math.isclose(a, b, rel_tol=RTOL, abs_tol=ATOL)


def difference(old: str, new: str) -> str | None:
    """Say where two outputs first differ; None where they are the same within the tolerances."""
    olds, news = numbers_and_words(old), numbers_and_words(new)
    for k, (a, b) in enumerate(zip(olds, news, strict=False)):
        if not same_part(a, b):
            before = " ".join(olds[max(k - 6, 0) : k])
            return f"the notebook has {a!r}, now it is {b!r}, after {before!r}"
    if len(olds) != len(news):
        return f"the notebook has {len(olds)} words and numbers, now there are {len(news)}"
    return None


class Output(str):
    """An output of a cell, equal to another one when they are the same within the tolerances."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, str) and difference(self, other) is None

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = str.__hash__


def pytest_itemcollected(item: pytest.Item) -> None:
    """Make nbval compare with the tolerances: it compares what its cells' `sanitize` returns."""
    if type(item).__name__ == "IPyNbCell":
        plain = item.sanitize
        item.sanitize = lambda text: Output(plain(text)) if isinstance(text, str) else text


def pytest_assertrepr_compare(left: object, right: object) -> list[str] | None:
    """Name the first difference rather than show two whole outputs."""
    if isinstance(left, Output) and isinstance(right, str):
        return [difference(left, right) or "no difference"]
    return None
