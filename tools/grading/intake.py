"""What teachers have on their disks: folders, zips and downloads, and whose each file is."""

import hashlib
import io
import os
import re
import unicodedata
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

MAX_FILE = 50_000_000  # bytes of one file
MAX_ZIP = 500_000_000  # bytes of all that a zip holds
MAX_DEPTH = 3  # zips within zips
MAX_BESIDE = 10_000_000  # bytes of the files that lie beside a notebook
LEFT_ASIDE = {".ipynb_checkpoints", "__MACOSX", "__pycache__", ".git", ".DS_Store", "Thumbs.db"}
NOTEBOOKS = {".ipynb", ".json"}
# What a student may hand in by mistake; a teacher's lists (.csv, .xlsx, .md) are not among them.
MISTAKEN = {".pdf", ".html", ".htm", ".py", ".docx", ".odt", ".txt", ".rar", ".7z", ".gz", ".tar"}

MOODLE = re.compile(r"(?P<name>.+)_(?P<id>\d+)_assignsubmission_(?:file|onlinetext)_?(?P<rest>.*)")
CANVAS = re.compile(r"(?P<name>[^_]+)(?:_LATE)?_(?P<id>\d{3,})_\d{3,}_(?P<rest>.+)")
COPY = re.compile(r"(?:[ _-]*\(\d+\)|[ _-]*copy ?\d*|-Copy\d+)+$", re.IGNORECASE)
NUMBERED = re.compile(
    r"(?<![^\W_])(?:chapter|exercises?|homework|sheet|ch|ex|hw)[ _.-]*\d+", re.IGNORECASE
)


@dataclass(frozen=True)
class File:
    """A file that was handed in: where it lay, in which folder of how many names, and its bytes."""

    parts: tuple[str, ...]
    data: bytes
    trouble: str = ""  # why there are no bytes

    @property
    def name(self) -> str:
        """The place, as one reads it."""
        return "/".join(self.parts)

    @property
    def suffix(self) -> str:
        """The ending, in small letters."""
        return PurePosixPath(self.parts[-1]).suffix.lower()

    @property
    def is_notebook(self) -> bool:
        """Whether it may be a notebook: browsers add .txt and .json to the ending."""
        return self.suffix in NOTEBOOKS or self.parts[-1].lower().endswith(".ipynb.txt")


@dataclass
class Student:
    """Whose files these are."""

    name: str
    number: str = ""  # what Moodle or Canvas knows them by
    files: list[File] = field(default_factory=list)

    def beside(self, notebook: File) -> dict[str, bytes]:
        """Return the small files that lie in the folder of a notebook, by their names there."""
        folder = notebook.parts[:-1]
        found = {}
        for file in self.files if folder else []:
            inside = file.parts[: len(folder)] == folder
            if inside and not file.is_notebook and file.suffix != ".zip" and not file.trouble:
                found["/".join(file.parts[len(folder) :])] = file.data
        return found if sum(map(len, found.values())) <= MAX_BESIDE else {}


@dataclass(frozen=True)
class Handed:
    """All that was handed in: the students, and what belongs to none."""

    students: list[Student]
    left: list[str]


def collect(place: Path, stems: list[str], exclude: Path | None = None) -> Handed:
    """Read a folder, a zip or one notebook, and say whose each file is."""
    if place.is_dir():
        files = [*_walk(place, exclude)]
    elif place.suffix.lower() == ".zip":
        files = [*_unzip((place.name,), place.read_bytes(), 1, folder=False)]
    else:
        files = [File((place.name,), place.read_bytes())]
    return _shared_out(_unwrapped(files, stems), stems, place.resolve().stem)


def _walk(place: Path, exclude: Path | None) -> Iterator[File]:
    """Yield the files of a folder; a folder without any is a file without a name."""
    for folder, folders, names in os.walk(place):
        here = Path(folder)
        folders[:] = sorted(
            one for one in folders if one not in LEFT_ASIDE and (here / one).resolve() != exclude
        )
        parts = here.relative_to(place).parts
        if parts and not folders and not names:
            yield File((*parts, ""), b"", "The folder is empty.")
        for name in sorted(names):
            yield from _opened((*parts, name), here / name)


def _opened(parts: tuple[str, ...], path: Path) -> Iterator[File]:
    if parts[-1] in LEFT_ASIDE or parts[-1].startswith("._"):
        return
    try:
        if path.stat().st_size > MAX_FILE:
            yield File(parts, b"", f"The file is larger than {MAX_FILE // 1_000_000} MB.")
        elif path.suffix.lower() == ".zip":
            yield from _unzip(parts, path.read_bytes(), 1)
        else:
            yield File(parts, path.read_bytes())
    except OSError as error:
        yield File(parts, b"", f"The file cannot be read: {error.strerror}.")


def _unzip(
    parts: tuple[str, ...], data: bytes, depth: int, *, folder: bool = True
) -> Iterator[File]:
    """Yield what a zip holds, as if it were a folder of its name; nothing goes to the disk."""
    inside = (*parts[:-1], PurePosixPath(parts[-1]).stem) if folder else ()
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(info.file_size for info in archive.infolist()) > MAX_ZIP or depth > MAX_DEPTH:
                yield File(parts, b"", "The zip holds too much, or zips within zips within zips.")
                return
            for info in archive.infolist():
                names = [name for name in _name(info).split("/") if name not in ("", ".", "..")]
                if info.is_dir() or not names or LEFT_ASIDE & set(names):
                    continue
                if names[-1].startswith("._"):
                    continue
                content = archive.read(info) if info.file_size <= MAX_FILE else b""
                if names[-1].lower().endswith(".zip"):
                    yield from _unzip((*inside, *names), content, depth + 1)
                else:
                    yield File((*inside, *names), content)
    except (zipfile.BadZipFile, RuntimeError, NotImplementedError, EOFError, OSError) as error:
        yield File(parts, b"", f"The zip cannot be opened: {error}.")


def _name(info: zipfile.ZipInfo) -> str:
    """Return a name in a zip; many programs write UTF-8 without saying so."""
    name = info.filename.replace("\\", "/")
    if not info.flag_bits & 0x800:
        try:
            return name.encode("cp437").decode("utf-8")
        except UnicodeError:
            pass
    return name


def _unwrapped(files: list[File], stems: list[str]) -> list[File]:
    """Leave out folders that hold all the rest: those of the class, of nbgrader, of one chapter."""
    while True:
        tops = {file.parts[0] for file in files if len(file.parts) > 1}
        if "submitted" in tops:  # a whole course of nbgrader
            files = [_inner(file) for file in files if file.parts[0] == "submitted"]
        elif any(file.parts[0] in stems for file in files if len(file.parts) > 1):
            return [_inner(file) if file.parts[0] in stems else file for file in files]
        elif len(tops) == 1 and _wraps(files, stems):
            files = [_inner(file) if len(file.parts) > 1 else file for file in files]
        else:
            return files


def _inner(file: File) -> File:
    return File(file.parts[1:], file.data, file.trouble) if len(file.parts) > 1 else file


def _wraps(files: list[File], stems: list[str]) -> bool:
    """Return whether the only folder is that of the class, and not that of a student."""
    within = [file.parts[1:] for file in files if len(file.parts) > 1]
    top = next(file.parts[0] for file in files if len(file.parts) > 1)
    loose = [file for file in files if len(file.parts) == 1 and file.is_notebook]
    if loose or MOODLE.fullmatch(top):
        return False
    folders = {parts[0] for parts in within if len(parts) > 1}
    flat = [parts[0] for parts in within if len(parts) == 1 and parts[0].endswith(".ipynb")]
    people = {_plain(person(name, stems)[0]) for name in flat} - {""}
    return len(people) > 1 or (not flat and bool(folders) and not folders & set(stems))


def person(name: str, stems: list[str]) -> tuple[str, str]:
    """Return the name and the number of the student in a file's or folder's name."""
    for download in (MOODLE, CANVAS):
        if found := download.fullmatch(name):
            return _tidy(found["name"]), found["id"]
    bare = re.sub(r"(\.ipynb)?\.\w{1,5}$", "", name)
    for stem in sorted(stems, key=len, reverse=True):
        number, _, words = stem.partition("_")
        words = re.escape(words).replace("_", "[ _-]")
        bare = re.sub(rf"(?:0?{number.lstrip('0')}[ _.-]*)?{words}", " ", bare, flags=re.IGNORECASE)
    return _tidy(NUMBERED.sub(" ", COPY.sub("", bare.strip()))), ""


def _tidy(name: str) -> str:
    return unicodedata.normalize("NFC", re.sub(r"\s+", " ", name)).strip(" _-.,()")


def _plain(name: str) -> str:
    """Return what two spellings of one name have in common."""
    return re.sub(r"[\s_.,-]+", " ", name).casefold().strip()


def _shared_out(files: list[File], stems: list[str], fallback: str) -> Handed:
    """Give each file to its student."""
    students: dict[tuple[str, ...], Student] = {}
    left = []
    for file in files:
        top = file.parts[0]
        if len(file.parts) > 1:
            found = MOODLE.fullmatch(top)
            name, number = person(top, stems) if found else (_tidy(top) or top, "")
            key = ("number", number) if number else ("folder", top)
        elif file.is_notebook or file.suffix in MISTAKEN or file.trouble or MOODLE.fullmatch(top):
            name, number = person(top, stems)
            key = ("number", number) if number else ("file", _plain(name))
        else:
            left.append(file.name)
            continue
        students.setdefault(key, Student(name or fallback, number)).files.append(file)
    return Handed(_apart(sorted(students.values(), key=lambda one: one.name.casefold())), left)


def _apart(students: list[Student]) -> list[Student]:
    """Tell students of the same name apart, by their numbers or by counting."""
    names = [student.name for student in students]
    for i, student in enumerate(students):
        if names.count(names[i]) > 1:
            student.name += f" ({student.number or names[: i + 1].count(names[i])})"
    return students


def digest(*pieces: bytes) -> str:
    """Return a fingerprint."""
    found = hashlib.sha256()
    for piece in pieces:
        found.update(len(piece).to_bytes(8, "big") + piece)
    return found.hexdigest()
