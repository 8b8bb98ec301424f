# SPDX-License-Identifier: MIT
"""The table of cameras that the workflow reads, and what each camera depends on.

The table is CSV with a header. Required columns: id, images, board. Optional ones: model, tolerance, previous; where a
field is empty, the default of the program holds. Only Python's standard library is needed.
"""
from __future__ import annotations

import csv
import dataclasses
import difflib
import glob
import os
import re
import unicodedata

REQUIRED = ("id", "images", "board")
OPTIONAL = ("model", "tolerance", "previous")
ID_PATTERN = r"[A-Za-z0-9][A-Za-z0-9._-]*"
MAX_ID_LENGTH = 100
# Those that alidade takes from a folder (docs/detection.md).
IMAGE_EXTENSIONS = (".jpg", ".jpeg", ".png", ".bmp", ".tif", ".tiff", ".pgm", ".ppm", ".pnm", ".webp")


class TableError(Exception):
    """What is wrong with the table: file, line, column, found, expected."""

    def __init__(self, path: str, line: int, column: str, found: str, expected: str) -> None:
        place = path + (f":{line}" if line else "") + (f": {column}" if column else "")
        super().__init__(f"{place}: found {found}; expected {expected}")


@dataclasses.dataclass(frozen=True)
class Camera:
    """One row of the table; paths are relative to the working directory. Empty: not given."""

    id: str
    images: str
    board: str
    model: str = ""
    tolerance: str = ""
    previous: str = ""


def read_table(path: str) -> list[Camera]:
    """Reads and checks the table. Raises TableError, or OSError where there is no such file."""
    with open(path, encoding="utf-8-sig", newline="") as file:
        reader = csv.reader(file, strict=True)
        try:
            header = next(reader, [])
            _check_header(path, header)
            cameras: list[Camera] = []
            lines: dict[str, int] = {}
            for fields in reader:
                if any(field.strip() for field in fields):
                    cameras.append(_camera(path, reader.line_num, header, fields, lines))
        except csv.Error as error:
            raise TableError(path, reader.line_num, "", f"a row that is no CSV ({error})",
                             "fields with commas or quotes in double quotes") from error
        except UnicodeDecodeError as error:
            raise TableError(path, reader.line_num + 1, "", "bytes that are no UTF-8", "a table in UTF-8") from error
    if not cameras:
        raise TableError(path, 1, "", "no cameras", "a row for each camera below the header")
    return cameras


def _check_header(path: str, header: list[str]) -> None:
    names = [name.strip() for name in header]
    for name in names:
        if name not in REQUIRED + OPTIONAL:
            near = difflib.get_close_matches(name, REQUIRED + OPTIONAL, 1)
            raise TableError(path, 1, "", f"the column '{name}'",
                             f"'{near[0]}'" if near else "the columns " + ", ".join(REQUIRED + OPTIONAL))
        if names.count(name) > 1:
            raise TableError(path, 1, "", f"the column '{name}' {names.count(name)} times", "each column once")
    for name in REQUIRED:
        if name not in names:
            raise TableError(path, 1, "", f"no column '{name}'", "a header with " + ", ".join(REQUIRED))


def _camera(path: str, line: int, header: list[str], fields: list[str], lines: dict[str, int]) -> Camera:
    if len(fields) != len(header):
        raise TableError(path, line, "", f"{len(fields)} fields", f"{len(header)}, as in the header")
    row = {name.strip(): field.strip() for name, field in zip(header, fields)}
    for name in REQUIRED:
        if not row[name]:
            raise TableError(path, line, name, "an empty field", "a value")
    for name, field in row.items():
        if any(unicodedata.category(character) == "Cc" for character in field):
            raise TableError(path, line, name, "a control character", "one line of text")
    key = row["id"]
    if not re.fullmatch(ID_PATTERN, key) or len(key) > MAX_ID_LENGTH:
        raise TableError(path, line, "id", f"'{key}'", "letters, digits, '.', '_' and '-', beginning with a letter "
                         f"or a digit, at most {MAX_ID_LENGTH}")
    # Files are named by it, and some file systems do not tell capitals from small letters.
    if key.lower() in lines:
        raise TableError(path, line, "id", f"'{key}', as in line {lines[key.lower()]}", "a different id for each camera")
    lines[key.lower()] = line
    folder = os.path.dirname(path)
    row["images"] = os.path.join(folder, row["images"])
    if row.get("previous"):
        row["previous"] = os.path.join(folder, row["previous"])
    if row["board"].endswith((".yaml", ".yml")):
        row["board"] = os.path.join(folder, row["board"])
    return Camera(**row)


def has_image_name(path: str) -> bool:
    """Whether a file is an image by its name; other files are videos."""
    return path.lower().endswith(IMAGE_EXTENSIONS)


def image_files(images: str) -> list[str]:
    """The files that the images of a camera consist of, sorted; none where there are none."""
    def in_folder(folder: str) -> list[str]:
        with os.scandir(folder or ".") as entries:
            return sorted(os.path.join(folder, e.name) for e in entries
                          if not e.name.startswith(".") and has_image_name(e.name) and not e.is_dir())

    try:
        if os.path.isdir(images):
            return in_folder(images)
        if os.path.exists(images):
            return [images]
        sequence = re.fullmatch(r"([^%]*)%0?\d*d([^%]*)", os.path.basename(images))
        if sequence:
            name = re.compile(re.escape(sequence[1]) + r"\d+" + re.escape(sequence[2]))
            return [path for path in in_folder(os.path.dirname(images)) if name.fullmatch(os.path.basename(path))]
        matches = sorted(glob.glob(images))
        return [path for match in matches for path in (in_folder(match) if os.path.isdir(match) else [match])]
    except OSError:
        return []  # the program says why


def settings_of(camera: Camera, settings: list[str]) -> list[str]:
    """The first lines of dependencies(): what does not depend on files."""
    return [*settings, f"images {camera.images}", f"board {camera.board}", f"model {camera.model}",
            f"tolerance {camera.tolerance}", f"previous {camera.previous}"]


def dependencies(camera: Camera, settings: list[str]) -> str:
    """All that the result of a camera depends on, as text: settings, and size and time of each file.

    Raises TableError for the name of an image that has a line break: each line is a file.
    """
    lines = settings_of(camera, settings)
    given = (camera.board, camera.previous, camera.previous.partition("#")[0])  # FILE#NAME is a camera of a file
    existing = [path for path in dict.fromkeys(given) if path and os.path.exists(path)]
    for kind, paths in (("setting", existing), ("image", image_files(camera.images))):
        for path in paths:
            if "\n" in path:
                raise TableError(camera.images, 0, "", f"the file name {path!r}", "a name without line breaks; rename it")
            try:
                # A file that becomes readable keeps size and time, and must change this text.
                if not os.access(path, os.R_OK):
                    raise PermissionError
                status = os.stat(path)
                lines.append(f"{kind} {status.st_size} {status.st_mtime_ns} {path}")
            except OSError:
                lines.append(f"{kind} - - {path}")
    return "\n".join(lines) + "\n"


def image_paths(text: str) -> list[str]:
    """The images in what dependencies() returned."""
    return [line.split(" ", 3)[3] for line in text.split("\n") if line.startswith("image ")]


def write_if_changed(path: str, text: str) -> bool:
    """Replaces a file at once, and only if its content differs: its time is that of the last change."""
    try:
        with open(path, encoding="utf-8", errors="surrogateescape", newline="") as file:
            if file.read() == text:
                return False
    except FileNotFoundError:
        os.makedirs(os.path.dirname(path), exist_ok=True)
    new = f"{path}.{os.getpid()}.new"
    with open(new, "w", encoding="utf-8", errors="surrogateescape", newline="") as file:
        file.write(text)
    os.replace(new, path)
    return True
