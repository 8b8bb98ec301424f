# SPDX-License-Identifier: MIT
"""Collects how the steps of all cameras ended, and makes one table and one page of the fleet.

usage: fleet_summary.py TABLE OUTPUT PROGRAM TOLERANCE JOBS
       fleet_summary.py --check CAMERAS_CSV
"""
from __future__ import annotations

import csv
import dataclasses
import glob
import io
import os
import re
import shutil
import subprocess
import sys

import camera_table

STEPS = ("detect", "calibrate", "diff", "validate", "report")
# What a step leaves, and the exit codes with which it does.
PRODUCTS = {
    "detect": [("corners", ".csv", "0")],
    "calibrate": [("calibrations", ".yaml", "0"), ("evidence", ".json", "03"), ("summaries", ".txt", "03")],
    "diff": [("differences", ".svg", "03"), ("differences", ".txt", "03")],
    "validate": [],
    "report": [("reports", ".html", "0")],
}
COLUMNS = ("camera", "status", "step", "exit_code", "reason")
PAGES = ("fleet.csv", "fleet.html")
USABLE = ("calibrated", "changed")
STATUSES = ("calibrated", "changed", "failed", "unfinished")


@dataclasses.dataclass(frozen=True)
class Outcome:
    """What became of a camera, and the step that decided it."""

    camera: str
    status: str
    step: str = ""
    exit_code: str = ""
    reason: str = ""


def record_path(output: str, camera: str, step: str) -> str:
    return os.path.join(output, "steps", camera, step)


def read_record(output: str, camera: str, step: str) -> tuple[str, str]:
    """The exit code and the messages of a step; ("", "") if it has not ended."""
    try:
        with open(record_path(output, camera, step), encoding="utf-8", errors="replace") as file:
            code, _, messages = file.read().partition("\n")
            return code, messages
    except FileNotFoundError:
        return "", ""


def steps_of(camera: camera_table.Camera) -> list[str]:
    return [step for step in STEPS if step != "diff" or camera.previous]


def forget_incomplete(output: str, camera: camera_table.Camera) -> None:
    """Removes the record of a step whose products somebody has removed, so that it is done again."""
    for step in steps_of(camera):
        code, _ = read_record(output, camera.id, step)
        for kind, extension, codes in PRODUCTS[step]:
            if code and code in codes and not os.path.exists(os.path.join(output, kind, camera.id + extension)):
                os.remove(record_path(output, camera.id, step))
                break


def forget_incomplete_pages(output: str) -> None:
    """Removes cameras.csv, which is written last, if somebody has removed the page or the table of the fleet."""
    path = os.path.join(output, "cameras.csv")
    if os.path.exists(path) and not all(os.path.exists(os.path.join(output, page)) for page in PAGES):
        with open(path, encoding="utf-8", newline="") as file:
            has_pages = any(row["status"] in USABLE for row in csv.DictReader(file))
        if has_pages:
            os.remove(path)


def reason_in(messages: str) -> str:
    """The line that says why: the error with what to do next, or what failed a check, or the first line."""
    lines = [line.strip() for line in messages.splitlines() if line.strip()]
    for start in ("error: ", "FAIL "):
        for i, line in enumerate(lines):
            if line.startswith(start):
                advice = lines[i + 1:i + 2] if lines[i + 1:i + 2] and lines[i + 1].startswith("next: ") else []
                return re.sub(r"\s+", " ", "; ".join([line.removeprefix("error: "), *advice]))
    return lines[0] if lines else ""


def outcome_of(output: str, camera: camera_table.Camera) -> Outcome:
    """What the records say. A camera that has changed is usable; all else that did not end with 0 is a failure."""
    changed = None
    for step in steps_of(camera):
        code, messages = read_record(output, camera.id, step)
        if not code:
            return Outcome(camera.id, "unfinished", step)
        if code == "3" and step == "diff":
            changed = Outcome(camera.id, "changed", step, code, reason_in(messages))
        elif code != "0":
            return Outcome(camera.id, "failed", step, code, reason_in(messages))
    return changed or Outcome(camera.id, "calibrated")


def table_of(outcomes: list[Outcome]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(dataclasses.astuple(outcome) for outcome in outcomes)
    return text.getvalue()


def ending(output: str, cameras: dict[str, camera_table.Camera]) -> str:
    """What the end of a run prints: the counts, and each camera that is not simply calibrated with its reason."""
    outcomes = [outcome_of(output, camera) for camera in cameras.values()]
    counts = ((sum(outcome.status == status for outcome in outcomes), status) for status in STATUSES)
    lines = [f"{len(outcomes)} camera{'' if len(outcomes) == 1 else 's'}: " + ", ".join(f"{count} {status}" for count, status in counts if count)]
    for outcome in outcomes:
        if outcome.status == "unfinished":
            lines.append(f"unfinished  {outcome.camera}: the step {outcome.step} has no answer; run the workflow again")
        elif outcome.status != "calibrated":
            lines.append(f"{outcome.status:<10}  {outcome.camera}: {outcome.step}: {outcome.reason}")
    if all(outcome.status != "unfinished" for outcome in outcomes):
        paths = [os.path.join(output, name) for name in ("cameras.csv", *PAGES)]
        lines.append("see " + ", ".join(path for path in paths if os.path.exists(path)))
    return "\n".join(lines)


def remove_leftovers(output: str) -> None:
    """Removes the temporary files of commands that were killed. Only for the end of a run: nothing is written then."""
    for pattern in ("*/.alidade-*.tmp", ".alidade-*.tmp", "steps/*/*.new"):
        for path in glob.glob(os.path.join(glob.escape(output), pattern)):
            os.remove(path)


def copy_previous(output: str, camera: camera_table.Camera) -> str:
    """Copies the previous file under the name of the camera, by which the program pairs files; returns its name."""
    source = camera.previous
    if not os.path.exists(source):  # FILE#NAME
        return os.path.relpath(source, os.path.join(output, "calibrations"))
    name = os.path.join("previous", camera.id + os.path.splitext(source)[1])
    path = os.path.join(output, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    shutil.copyfile(source, f"{path}.{os.getpid()}.new")
    os.replace(f"{path}.{os.getpid()}.new", path)
    return os.path.join("..", name)


def summarise(table: str, output: str, program: str, tolerance: str, jobs: str) -> int:
    """Writes fleet.csv and fleet.html over all usable cameras, then cameras.csv. Returns an exit code."""
    cameras = camera_table.read_table(table)
    outcomes = [outcome_of(output, camera) for camera in cameras]
    usable = {outcome.camera for outcome in outcomes if outcome.status in USABLE}
    previous = [copy_previous(output, camera) for camera in cameras if camera.id in usable and camera.previous]
    for page in PAGES:
        if not usable:
            if os.path.exists(os.path.join(output, page)):
                os.remove(os.path.join(output, page))
            continue
        # From their own folder, so that the paths in the table do not depend on where the output lies.
        run = subprocess.run(
            [program, "fleet", *(camera.id + ".yaml" for camera in cameras if camera.id in usable),
             *(["--previous", *previous] if previous else []), "--tolerance", tolerance, "--jobs", jobs, "--quiet",
             "-o", os.path.join("..", page)], cwd=os.path.join(output, "calibrations"), check=False)
        if run.returncode != 0:
            return 1
    camera_table.write_if_changed(os.path.join(output, "cameras.csv"), table_of(outcomes))
    os.utime(os.path.join(output, "cameras.csv"))
    return 0


def check(table: str) -> int:
    """The exit code of a strict run: 1 if a camera failed."""
    with open(table, encoding="utf-8", newline="") as file:
        return 1 if any(row["status"] == "failed" for row in csv.DictReader(file)) else 0


if __name__ == "__main__":
    sys.exit(check(sys.argv[2]) if sys.argv[1:2] == ["--check"] else summarise(*sys.argv[1:]))
