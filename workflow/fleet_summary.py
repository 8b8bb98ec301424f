# SPDX-License-Identifier: MIT
"""Collects how the steps of all cameras ended, and makes one table and one page of the fleet.

usage: fleet_summary.py OUTPUT PROGRAM JOBS
       fleet_summary.py --check CAMERAS_CSV
"""
from __future__ import annotations

import contextlib
import csv
import dataclasses
import fcntl
import glob
import hashlib
import io
import json
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


def cameras_path(output: str) -> str:
    return os.path.join(output, "steps", ".cameras")


def write_cameras(output: str, cameras: list[camera_table.Camera], tolerance: str) -> bool:
    """Writes the rows that this run works on, for its jobs and its end; returns whether they have changed."""
    rows = ",\n".join(json.dumps(dataclasses.asdict(camera)) for camera in cameras)
    text = f'{{"tolerance": {json.dumps(tolerance)}, "cameras": [\n{rows}\n]}}\n'
    return camera_table.write_if_changed(cameras_path(output), text)


def read_cameras(output: str) -> tuple[list[camera_table.Camera], str]:
    """The rows that write_cameras() wrote, and the tolerance of the fleet."""
    with open(cameras_path(output), encoding="utf-8") as file:
        content = json.load(file)
    return [camera_table.Camera(**row) for row in content["cameras"]], content["tolerance"]


def hash_of_inputs(output: str, camera: str) -> str:
    """The SHA-256 of what the camera depends on, which its records must hold."""
    with open(record_path(output, camera, "inputs"), "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def read_record(output: str, camera: str, step: str, expected_hash: str) -> tuple[str, str]:
    """The exit code and the messages of a step; ("", "") if it has not ended for these inputs."""
    try:
        with open(record_path(output, camera, step), encoding="utf-8", errors="replace") as file:
            code, inputs, messages = (file.read().split("\n", 2) + ["", ""])[:3]
    except FileNotFoundError:
        return "", ""
    return (code, messages) if inputs == f"inputs {expected_hash}" else ("", "")


def steps_of(camera: camera_table.Camera) -> list[str]:
    return [step for step in STEPS if step != "diff" or camera.previous]


def forget_outdated(output: str, camera: camera_table.Camera) -> bool:
    """Removes the records of other inputs, and those from the first step on whose products somebody has removed.

    Returns whether any was removed or is missing.
    """
    folder = os.path.join(output, "steps", camera.id)
    expected_hash = hash_of_inputs(output, camera.id)
    # Commands of a killed run may still write to the temporary files.
    names = [name for name in os.listdir(folder)
             if name != "inputs" and not name.startswith(".") and not name.endswith(".new")]
    outdated = {name for name in names if not read_record(output, camera.id, name, expected_hash)[0]}
    steps = steps_of(camera)
    for i, step in enumerate(steps):
        code, _ = read_record(output, camera.id, step, expected_hash)
        if any(code and code in codes and not os.path.exists(os.path.join(output, kind, camera.id + extension))
               for kind, extension, codes in PRODUCTS[step]):
            outdated.update(name for name in steps[i:] if name in names)
    for name in outdated:
        os.remove(os.path.join(folder, name))
    return bool(outdated) or not set(steps) <= set(names)


def forget_outdated_pages(output: str, is_current: bool) -> None:
    """Removes cameras.csv, which is written last, unless it and the page and the table of the fleet are up to date."""
    path = os.path.join(output, "cameras.csv")
    if os.path.exists(path) and is_current and not all(os.path.exists(os.path.join(output, page)) for page in PAGES):
        with open(path, encoding="utf-8", newline="") as file:
            is_current = not any(row["status"] in USABLE for row in csv.DictReader(file))
    if not is_current and os.path.exists(path):
        os.remove(path)


def copy_records(output: str, copy: str) -> None:
    """Makes a folder with copies of all that a run changes before its first step; the results are links."""
    os.makedirs(os.path.join(copy, "steps"))
    if not os.path.isdir(output):
        return
    for name in os.listdir(output):
        source, target = os.path.join(os.path.abspath(output), name), os.path.join(copy, name)
        if name == "steps":
            shutil.copytree(source, target, dirs_exist_ok=True)
        elif name == "cameras.csv":
            shutil.copy2(source, target)
        elif name != ".lock":
            os.symlink(source, target)


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
    expected_hash = hash_of_inputs(output, camera.id)
    for step in steps_of(camera):
        code, messages = read_record(output, camera.id, step, expected_hash)
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
        if not os.path.exists(os.path.join(output, "cameras.csv")):
            return "\n".join([*lines, "unfinished  the table and the page of the fleet; run the workflow again"])
        paths = [os.path.join(output, name) for name in ("cameras.csv", *PAGES)]
        lines.append("see " + ", ".join(path for path in paths if os.path.exists(path)))
    return "\n".join(lines)


def remove_leftovers(output: str) -> None:
    """Removes the temporary files of commands that were killed. Only for the end of a run: nothing is written then."""
    for pattern in ("*/.alidade-*.tmp", ".alidade-*.tmp", "steps/*/*.new", "steps/.cameras.*.new", "cameras.csv.*.new",
                    "previous/*.new"):
        for path in glob.glob(os.path.join(glob.escape(output), pattern)):
            with contextlib.suppress(FileNotFoundError):  # its command may still run and end
                os.remove(path)


def copy_previous(output: str, program: str, camera: camera_table.Camera) -> str:
    """Copies the previous file under the name of the camera, by which the program pairs files; returns its name.

    Of FILE#NAME only that camera is written. Raises CalledProcessError, after the program has said why.
    """
    source = camera.previous
    is_file = os.path.exists(source)
    name = os.path.join("previous", camera.id + (os.path.splitext(source)[1] if is_file else ".yaml"))
    path = os.path.join(output, name)
    new = f"{path}.{os.getpid()}.new"
    os.makedirs(os.path.dirname(path), exist_ok=True)
    if is_file:
        shutil.copyfile(source, new)
    else:  # whether the earlier camera can be trusted is not the question
        subprocess.run([program, "convert", source, "-o", new, "--keep-untrustworthy", "--quiet"], check=True)
    os.replace(new, path)
    return os.path.join("..", name)


def summarise(output: str, program: str, jobs: str) -> int:
    """Writes fleet.csv and fleet.html over all usable cameras, then cameras.csv. Returns an exit code."""
    cameras, tolerance = read_cameras(output)
    lock = open(os.path.join(output, "steps", ".lock"), "w", encoding="utf-8")
    with contextlib.suppress(OSError):  # the run has said that there are no locks
        fcntl.flock(lock, fcntl.LOCK_EX)  # that of a killed run may still write; its command inherits this
    outcomes = [outcome_of(output, camera) for camera in cameras]
    usable = {outcome.camera for outcome in outcomes if outcome.status in USABLE}
    try:
        previous = [copy_previous(output, program, camera) for camera in cameras if camera.id in usable and camera.previous]
        for page in PAGES:
            if not usable:
                with contextlib.suppress(FileNotFoundError):
                    os.remove(os.path.join(output, page))
                continue
            # From their own folder, so that the paths in the table do not depend on where the output lies.
            subprocess.run(
                [program, "fleet", *(camera.id + ".yaml" for camera in cameras if camera.id in usable),
                 *(["--previous", *previous] if previous else []), "--tolerance", tolerance, "--jobs", jobs, "--quiet",
                 "-o", os.path.join("..", page)],
                cwd=os.path.join(output, "calibrations"), check=True, pass_fds=[lock.fileno()])
    except subprocess.CalledProcessError as error:
        print(f"{error.cmd[0]} {error.cmd[1]} ended with code {error.returncode}; run the workflow again", file=sys.stderr)
        return 1
    if (cameras, tolerance) != read_cameras(output) or outcomes != [outcome_of(output, camera) for camera in cameras]:
        print(f"{output}: another run has begun meanwhile; its end makes the page of the fleet", file=sys.stderr)
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
