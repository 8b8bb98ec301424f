#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the workflow on a dozen simulated cameras on this machine: local_test.py PROGRAM

The results must be those of the single commands, for any number of processors, and whatever is killed on the way.
"""
import csv
import fcntl
import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

import simulated_fleet
from simulated_fleet import ALL, NUM_VIEWS, WORKFLOW, SimulatedFleet, content

sys.dont_write_bytecode = True
sys.path.insert(0, WORKFLOW)
import camera_table  # noqa: E402

PROGRAM = os.path.abspath(sys.argv.pop(1)) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else ""
STEPS_OF_ALL = 4 * len(ALL) + 2  # detect, calibrate, validate, report; and two have a previous file
SCRATCH = FLEET = REFERENCE = None


def setUpModule():
    """Renders once, and makes the run that the others are compared with."""
    global SCRATCH, FLEET, REFERENCE
    SCRATCH = tempfile.TemporaryDirectory(prefix="alidade-workflow-")
    FLEET = SimulatedFleet(SCRATCH.name, PROGRAM)
    REFERENCE = FLEET.work("reference")
    code, printed = REFERENCE.run("--cores", "2")
    if code != 0:
        raise AssertionError(printed)


def tearDownModule():
    SCRATCH.cleanup()


class WholeRun(unittest.TestCase):
    def test_names_each_camera_that_is_not_simply_calibrated(self):
        printed = REFERENCE.printed()
        self.assertIn("12 cameras: 9 calibrated, 1 changed, 2 failed\n", printed)
        self.assertRegex(printed, r"\nchanged     drifted: diff: changed: the cameras differ by [0-9.]+ px \(95 %\); limit 0.5 px")
        self.assertRegex(printed, r"\nfailed      mixed: calibrate: the camera must not be used: the views fall into two groups")
        self.assertRegex(printed, r"\nfailed      broken: detect: .*read")
        rows = content(REFERENCE.path("fleet/cameras.csv")).decode().splitlines()
        self.assertEqual(rows[0], "camera,status,step,exit_code,reason")
        self.assertEqual([row.split(",")[0] for row in rows[1:]], ALL)
        self.assertEqual(sum(row.endswith(",calibrated,,,") for row in rows), 9)
        with open(REFERENCE.path("fleet/fleet.csv"), encoding="utf-8", newline="") as file:
            drift = {row["name"]: row["drift_status"] for row in csv.DictReader(file)}
        self.assertEqual(len(drift), 10)
        self.assertEqual({name: status for name, status in drift.items() if status},
                         {"steady": "unchanged", "drifted": "drifted"})

    def test_each_step_ran_once(self):
        calls = REFERENCE.take_log()
        ran = [call for call in calls if call[0] != "fleet"]
        self.assertEqual(len(ran), len(set(ran)), calls)
        self.assertEqual(calls.count(("fleet", "")), 2)  # the table and the page
        # "broken" has no corners, and "mixed" no camera file.
        self.assertEqual(len(ran), STEPS_OF_ALL - 3 - 1)

    def test_outputs_are_those_of_the_single_commands(self):
        by_hand = FLEET.work("by_hand")
        by_hand.run_by_hand(PROGRAM)
        expected, found = by_hand.outputs(), REFERENCE.outputs()
        # Corners, camera, summary, evidence, page of nine cameras and "drifted"; "mixed" has no camera file; two
        # differences of two files each, two previous files, two files of the fleet; "broken" left an empty summary.
        num_compared = 0
        for name, text in expected.items():
            with self.subTest(name):
                self.assertEqual(found.get(name), text)
                num_compared += 1
        self.assertEqual(num_compared, 10 * 5 + 4 + 2 * 2 + 2 + 2)
        others = {name for name in found if not name.startswith("steps/")} - set(expected)
        self.assertEqual(others, {"cameras.csv"})

    def test_the_same_for_one_processor_and_without_profile(self):
        one = FLEET.work("one")
        code, printed = one.run("--cores", "1", profile=None)
        self.assertEqual(code, 0, printed)
        self.assert_same(one)

    def test_chunks_give_the_corners_of_one_search(self):
        cameras = ["cam02", "drifted", "broken"]
        chunked = FLEET.work("chunked", cameras)
        code, printed = chunked.run("--until", "detect_chunk", config=["chunk=3"])
        self.assertEqual(code, 0, printed)
        searched = self.cache_of(chunked)
        self.assertEqual(len(searched), 2 * NUM_VIEWS)
        code, printed = chunked.run(config=["chunk=3", "pictures=true"])
        self.assertEqual(code, 0, printed)
        self.assertEqual(self.cache_of(chunked), searched)  # no image was searched again
        for name in cameras[:2]:
            for kind in (f"corners/{name}.csv", f"calibrations/{name}.yaml"):
                self.assertEqual(content(chunked.path("fleet", kind)), content(REFERENCE.path("fleet", kind)), kind)
        subprocess.run([PROGRAM, "report", "fleet/evidence/cam02.json", "--images", "photos/cam02", "-o", "page.html"],
                       cwd=chunked.folder, check=True, capture_output=True)
        self.assertEqual(content(chunked.path("fleet/reports/cam02.html")), content(chunked.path("page.html")))
        self.assertNotEqual(content(chunked.path("page.html")), content(REFERENCE.path("fleet/reports/cam02.html")))

    def test_runs_share_a_cache(self):
        first = FLEET.work("first", ["cam04"])
        second = FLEET.work("second", ["cam04", "cam05"])
        for work in (first, second):
            code, printed = work.run(config=["cache=../shared_cache"])
            self.assertEqual(code, 0, printed)
        self.assertEqual(len(self.entries(os.path.join(FLEET.folder, "shared_cache"))), 2 * NUM_VIEWS)

    @staticmethod
    def cache_of(work):
        """The entries of the cache with their times."""
        return {path: os.stat(path).st_mtime_ns for path in WholeRun.entries(work.path("fleet", "cache"))}

    @staticmethod
    def entries(cache):
        """One file for each image; not what marks the folder as a cache, nor what a killed command left."""
        return [os.path.join(folder, name) for folder, _, names in os.walk(cache) for name in names
                if name != "CACHEDIR.TAG" and not name.endswith(".tmp")]

    def assert_same(self, work):
        expected, found = REFERENCE.outputs(), work.outputs()
        self.assertEqual(set(found), set(expected))
        self.assertGreater(len(expected), 100)
        for name, text in expected.items():
            self.assertEqual(found[name], text, name)


class AgainAndAgain(unittest.TestCase):
    def test_only_what_has_changed_is_done_again(self):
        # A copy of the reference would have new photographs' times, so this is a run of its own.
        cameras = ["cam02", "cam03", "steady", "broken"]
        work = FLEET.work("again", cameras)
        os.remove(work.path("photos"))
        for name in cameras:
            shutil.copytree(FLEET.photos(name), work.path("photos", name))

        def rerun(**options):
            work.take_log()
            code, printed = work.run(**options)
            self.assertEqual(code, 0, printed)
            return work.take_log()

        self.assertEqual(len(rerun()), 3 * 4 + 1 + 1 + 2)
        self.assertEqual(rerun(), [])
        # Another tolerance for all: but cam03 has its own, and "broken" has no corners to calibrate from.
        again = rerun(config=["tolerance=3px"])
        self.assertEqual(sorted({camera for _, camera in again}), ["", "broken", "cam02", "steady"])
        self.assertEqual(len(again), 4 + 5 + 1 + 2)
        self.assertEqual(len(rerun()), 4 + 5 + 1 + 2)
        self.assertIn("4 cameras: 3 calibrated, 1 failed", work.printed())
        for_one = [("detect", "cam02"), ("calibrate", "cam02"), ("validate", "cam02"), ("report", "cam02"),
                   ("fleet", ""), ("fleet", "")]
        searched = WholeRun.cache_of(work)
        shutil.copy(os.path.join(FLEET.folder, "new.png"), work.path("photos/cam02"))  # one new photograph
        self.assertEqual(rerun(), for_one)
        found = WholeRun.cache_of(work)
        self.assertEqual(len(found), len(searched) + 1)
        self.assertEqual({path: found.get(path) for path in searched}, searched)  # only it was searched
        os.remove(work.path("photos/cam02/new.png"))  # and one less
        self.assertEqual(rerun(), for_one)
        os.remove(work.path("fleet/calibrations/cam02.yaml"))  # a result that somebody removed
        self.assertEqual(rerun(), for_one[1:])
        os.remove(work.path("fleet/fleet.html"))
        self.assertEqual(rerun(), for_one[-2:])
        table = content(work.path("cameras.csv")).decode()
        with open(work.path("cameras.csv"), "w", encoding="utf-8") as file:  # other settings
            file.write(table.replace("photos/cam02,checkerboard:6x5:30mm,,", "photos/cam02,checkerboard:6x5:30mm,,2px"))
        self.assertEqual(rerun(), for_one)
        with open(work.path("cameras.csv"), "w", encoding="utf-8") as file:  # a camera less
            file.write("".join(line for line in table.splitlines(True) if not line.startswith("cam03")))
        # The old settings of cam02 are back, too.
        self.assertEqual(rerun(), for_one)
        self.assertNotIn("cam03", content(work.path("fleet/fleet.csv")).decode())
        shutil.copy(FLEET.photos("cam03") + "/view_001.png", work.path("photos/broken/c.png"))  # fewer than three views
        self.assertEqual([call for call in rerun() if call[1]], [("detect", "broken"), ("calibrate", "broken")])
        self.assertRegex(work.printed(), r"failed      broken: calibrate: .* at least 3 views")


class Killed(unittest.TestCase):
    MIN_KILLS = 4
    MOST_COMMANDS = 10  # before a kill
    MAX_KILLS = max(8, int(os.environ.get("ALIDADE_PROOF_KILLS", "80")) // 10)

    def test_resumes_after_kills_at_random_moments(self):
        draw = random.Random(5)
        work = FLEET.work("killed")
        expected = REFERENCE.outputs()
        num_kills = num_partial = 0
        while True:
            done = work.records()
            cached = WholeRun.cache_of(work)
            work.take_log()
            run = work.start("--cores", "2")
            try:
                # Most moments are some commands after the start, so that the speed of the machine does not matter.
                if draw.random() < 0.8:
                    self.wait_for_commands(work, run, draw.randrange(1, self.MOST_COMMANDS))
                    wait = draw.uniform(0.0, 0.05)
                else:
                    wait = draw.uniform(0.0, 1.0)
                code = run.wait(wait if num_kills < self.MAX_KILLS else 300)
            except subprocess.TimeoutExpired:
                os.killpg(run.pid, signal.SIGKILL)
                run.wait()
                code = None
                num_kills += 1
            calls = work.take_log()
            self.assertEqual([call for call in calls if call in done], [], "what was recorded was done again")
            self.assertLessEqual(done, work.records(), "a record was lost")
            for path, changed in cached.items():
                self.assertEqual(os.stat(path).st_mtime_ns, changed, "an image was searched again")
            for name, text in work.outputs().items():  # nothing is half-written
                self.assertEqual(text, expected.get(name), f"{name} after {num_kills} kills")
            num_partial += 0 < len(work.records()) < STEPS_OF_ALL
            if code is not None:
                break
        self.assertEqual(code, 0, work.printed())
        self.assertEqual(work.outputs(), expected)
        self.assertEqual(work.leftovers(), [])
        self.assertGreaterEqual(num_kills, self.MIN_KILLS)
        self.assertGreaterEqual(num_partial, self.MIN_KILLS - 1, "too few kills fell into the work")
        print(f"{num_kills} kills, {num_partial} of them during the work", file=sys.stderr)

    @staticmethod
    def wait_for_commands(work, run, count):
        """Until the run has started so many commands, or ended."""

        def started():
            try:
                return len(content(work.path("log")).splitlines())
            except FileNotFoundError:
                return 0

        while run.poll() is None and started() < count:
            time.sleep(0.01)

    def test_a_killed_step_is_no_result(self):
        work = FLEET.work("traps", ["cam01", "cam02"])
        for trap, step in (("kill calibrate fleet/corners/cam02", "calibrate"), ("memory validate fleet/calibrations/cam02", "validate")):
            work.set_trap(*trap.split(" ", 1))
            code, printed = work.run()
            self.assertEqual(code, 1)
            self.assertIn("2 cameras: 1 calibrated, 1 unfinished", printed)
            self.assertIn(f"unfinished  cam02: the step {step} has no answer; run the workflow again", printed)
            self.assertFalse(os.path.exists(work.path("fleet/cameras.csv")))
            self.assertTrue(os.path.exists(work.path("fleet/reports/cam01.html")))
        work.set_trap()
        work.take_log()
        code, printed = work.run()
        self.assertEqual(code, 0, printed)
        self.assertEqual(work.take_log(), [("validate", "cam02"), ("report", "cam02"), ("fleet", ""), ("fleet", "")])


class ChangedAndKilled(unittest.TestCase):
    """Results of old settings and photographs are never taken for new ones, whatever ends on the way."""

    def model_of(self, work, camera):
        text = content(work.path("fleet/calibrations", camera + ".yaml")).decode()
        found = [line.split(": ")[1] for line in text.splitlines() if line.strip().startswith("model: ")]
        self.assertEqual(len(found), 1)
        return found[0]

    def assert_nothing_to_do(self, work, **options):
        work.take_log()
        code, printed = work.run(**options)
        self.assertEqual((code, work.take_log()), (0, []), printed)

    def test_a_redo_that_ends_between_two_steps(self):
        work = FLEET.work("redo", ["cam02"])
        os.remove(work.path("photos"))
        shutil.copytree(FLEET.photos("cam02"), work.path("photos/cam02"))
        chunks = {"config": ["chunk=3"]}
        code, printed = work.run("--dry-run", config=["chunk=0"])
        self.assertEqual(code, 0, printed)
        self.assertIn("rule detect:", printed)
        self.assertNotIn("detect_chunk", printed)
        self.assertFalse(os.path.exists(work.path("fleet")))
        code, printed = work.run(**chunks)
        self.assertEqual(code, 0, printed)
        shutil.copy(os.path.join(FLEET.folder, "new.png"), work.path("photos/cam02"))
        before = self.all_files(work)
        code, printed = work.run("--dry-run", **chunks)
        self.assertEqual(code, 0, printed)
        self.assertIn("rule calibrate:", printed)
        self.assertEqual(self.all_files(work), before, "a dry run has changed the output")
        # A search of a chunk is killed, or fails without an answer. xargs gives the same code for all errors.
        for kind in ("kill", "memory"):
            work.set_trap(kind, "detect --board")
            code, printed = work.run(**chunks)
            self.assertEqual(code, 1, printed)
            self.assertIn("1 camera: 1 unfinished", printed)
            self.assertNotIn("cameras.csv", printed.splitlines()[-1])
            self.assertFalse(os.path.exists(work.path("fleet/cameras.csv")))
            self.assertEqual(sorted(os.listdir(work.path("fleet/steps/cam02"))), [".lock", "inputs"])
        work.set_trap()
        # A cache that takes no results: then the chunks are of no use.
        os.mkdir(work.path("blocked"))
        for i in range(256):
            open(work.path("blocked", f"{i:02x}"), "w", encoding="utf-8").close()
        code, printed = work.run(config=["chunk=3", "cache=blocked"])
        self.assertEqual(code, 1, printed)
        self.assertIn("results are not in the cache", printed)
        self.assertEqual(work.records(), set())
        code, printed = work.run("--until", "detect", **chunks)
        self.assertEqual(code, 0, printed)
        self.assertEqual(work.records(), {("detect", "cam02")})
        work.take_log()
        code, printed = work.run(**chunks)
        self.assertEqual(code, 0, printed)
        self.assertIn(("calibrate", "cam02"), work.take_log())
        self.assertIn(b"new.png", content(work.path("fleet/evidence/cam02.json")))
        self.assert_killed_after_detect(work)

    def assert_killed_after_detect(self, work):
        work.set_row("cam02", model="kannala_brandt")
        record = work.path("fleet/steps/cam02/detect")
        before = os.stat(record).st_mtime_ns

        def has_new_record():
            return os.path.exists(record) and os.stat(record).st_mtime_ns != before

        run = work.start()
        while run.poll() is None and not has_new_record():
            time.sleep(0.001)
        os.killpg(run.pid, signal.SIGKILL)
        run.wait()
        self.assertTrue(has_new_record(), work.printed())
        for name in ("cameras.csv.1.new", "previous/cam02.yaml.1.new", "steps/.cameras.1.new", "steps/cam02/calibrate.1.new"):
            os.makedirs(os.path.dirname(work.path("fleet", name)), exist_ok=True)
            open(work.path("fleet", name), "w", encoding="utf-8").close()
        code, printed = work.run()
        self.assertEqual(code, 0, printed)
        self.assertEqual(self.model_of(work, "cam02"), "kannala_brandt")
        self.assertEqual(work.leftovers(), [])
        self.assert_nothing_to_do(work)

    @staticmethod
    def all_files(work):
        return {path: (os.stat(path).st_mtime_ns, content(path)) for folder, _, names in os.walk(work.path("fleet"))
                for path in (os.path.join(folder, name) for name in names)}

    def test_a_command_that_outlives_its_run(self):
        work = FLEET.work("orphan", ["steady"])
        # The previous file is one camera of a file.
        subprocess.run([PROGRAM, "convert", "last/steady.yaml", "--to", "kalibr", "--model", "kannala_brandt", "--quiet",
                        "-o", "chain.yaml"], cwd=work.folder, check=True, capture_output=True)
        work.set_row("steady", model="radtan", previous="chain.yaml#cam0")
        open(work.path("hold"), "w", encoding="utf-8").close()
        work.set_trap("hold", "calibrate")
        run = work.start()
        while run.poll() is None and ("calibrate", "steady") not in work.calls():
            time.sleep(0.02)
        run.kill()  # the command goes on
        run.wait()
        work.set_trap()
        work.set_row("steady", model="kannala_brandt")
        run = work.start()
        while run.poll() is None and "waiting for a step of this camera" not in work.printed():
            time.sleep(0.02)
        self.assertIsNone(run.poll(), work.printed())
        # What somebody writes to the table during a run is for the next one.
        table = content(work.path("cameras.csv"))
        with open(work.path("cameras.csv"), "ab") as file:
            file.write(b"other,photos/cam01\n")
        os.remove(work.path("hold"))
        self.assertEqual(run.wait(300), 0, work.printed())
        self.assertIn("1 camera: 1 ", work.printed())
        self.assertEqual(self.model_of(work, "steady"), "kannala_brandt")
        self.assertEqual(len(content(work.path("fleet/cameras.csv")).splitlines()), 2)
        with open(work.path("fleet/fleet.csv"), encoding="utf-8", newline="") as file:
            rows = [(row["name"], row["drift_status"]) for row in csv.DictReader(file)]
        self.assertEqual([(name, bool(status)) for name, status in rows], [("steady", True)])
        with open(work.path("cameras.csv"), "wb") as file:
            file.write(table)
        self.assert_nothing_to_do(work)

    def test_what_a_step_records(self):
        inputs = b"image 1 2 a.png\n"
        hash_of_inputs = hashlib.sha256(inputs).hexdigest()
        of_inputs, of_others = f"inputs {hash_of_inputs}\n", f"inputs {'0' * 64}\n"
        record, earlier = "steps/cam/detect", "steps/cam/earlier"
        cases = [  # hash, earlier record, options, command; expected record, or what is printed without one
            (hash_of_inputs, "", [], "echo text >&2", f"0\n{of_inputs}text\n", ""),
            (hash_of_inputs, "", [], "exit 2", f"2\n{of_inputs}", ""),
            (hash_of_inputs, "", [], "exit 123", f"1\n{of_inputs}", ""),
            (hash_of_inputs, "0\n" + of_inputs, ["--after", earlier], "true", f"0\n{of_inputs}", ""),
            (hash_of_inputs, "3\n" + of_inputs, ["--after-answer", earlier], "true", f"0\n{of_inputs}", ""),
            (hash_of_inputs, "3\n" + of_inputs, ["--after", earlier], "true",
             f"skipped\n{of_inputs}no answer of the step earlier\n", ""),
            (hash_of_inputs, "0\n" + of_others, ["--after", earlier], "true", None, "earlier is of other inputs"),
            ("0" * 64, "", [], "true", None, "inputs has changed since"),
            (hash_of_inputs, "", [], "echo >>steps/cam/inputs", None, "inputs has changed since"),
            (hash_of_inputs, "", [], "exit 4", None, "ended with code 4"),
            (hash_of_inputs, "", [], "kill -KILL $$", None, "ended with code 137"),
            (hash_of_inputs, "", [], "echo 'error: out of memory' >&2; exit 1", None, "out of memory"),
            (hash_of_inputs, "", [], "echo 'error: out of memory' >&2; exit 123", None, "out of memory"),
            (hash_of_inputs, "", [], "echo 'error: a.csv: cannot be written: full' >&2; exit 1", None, "cannot be written"),
            (hash_of_inputs, "", [], "echo 'error: --cache a: Not a directory' >&2; exit 1", None, "--cache a: Not a"),
            (hash_of_inputs, "", [], "echo 'a.png: cannot be read: Input/output error' >&2", None, "Input/output error"),
            (hash_of_inputs, "", [], "echo 'a.png: cannot be read: Stale file handle' >&2; exit 1", None, "Stale file handle"),
            (hash_of_inputs, "", ["--beside", "--unless", "no cache"], "echo 'note: no cache' >&2", None, "no cache"),
        ]
        for given, before, options, command, expected, message in cases:
            with self.subTest(command=command, options=options), tempfile.TemporaryDirectory() as folder:
                os.makedirs(os.path.join(folder, "steps/cam"))
                for name, text in (("inputs", inputs), ("earlier", before.encode())):
                    with open(os.path.join(folder, "steps/cam", name), "wb") as file:
                        file.write(text)
                run = subprocess.run([os.path.join(WORKFLOW, "step"), record, given, *options, "--", "sh", "-c", command],
                                     cwd=folder, capture_output=True, text=True, check=False)
                self.assertEqual(run.returncode, 0 if expected else 1, run.stderr)
                self.assertIn(message, run.stderr)
                left = set(os.listdir(os.path.join(folder, "steps/cam"))) - {"inputs", "earlier", ".lock"}
                self.assertEqual(left, {"detect"} if expected else set())
                if expected:
                    self.assertEqual(content(os.path.join(folder, record)).decode(), expected)
        self.assertEqual(len(cases), 18)


class Refused(unittest.TestCase):
    def test_strict_fails_for_a_camera_that_failed(self):
        work = FLEET.work("strict", ["cam01", "broken"])
        code, printed = work.run(config=["strict=true"])
        self.assertEqual(code, 1)
        self.assertIn("2 cameras: 1 calibrated, 1 failed", printed)
        code, printed = work.run()
        self.assertEqual(code, 0, printed)
        work.take_log()
        os.symlink(FLEET.photos("cam03"), work.path("others"))
        with open(work.path("cameras.csv"), "w", encoding="utf-8") as file:
            file.write("id,images,board\ncam01,others,circles:9x\ncameras,others,circles:9x\n")
        code, printed = work.run()
        self.assertEqual(code, 0, printed)
        self.assertIn("2 cameras: 2 failed", printed)
        self.assertRegex(printed, r"failed      cam01: detect: .*circles:9x")
        # No camera is left, so there is no page; and nothing old is taken for a new result.
        for name in ("fleet.html", "fleet.csv", "calibrations/cam01.yaml", "corners/cam01.csv"):
            self.assertFalse(os.path.exists(work.path("fleet", name)), name)

    def test_wrong_settings(self):
        work = FLEET.work("settings", ["cam01"])
        cases = [
            (["tabel=x.csv"], "--config: found 'tabel'; expected one of: table, "),
            (["chunk=-1"], "--config chunk: found '-1'; expected a number of at least 0"),
            (["chunk=many"], "--config chunk: found 'many'; expected a number of at least 0"),
            (["strict=perhaps"], "--config strict: found 'perhaps'; expected true or false"),
            (["alidade=./nowhere"], "--config alidade: found no program './nowhere'"),
            (["table=none.csv"], "none.csv"),
        ]
        for config, message in cases:
            with self.subTest(config):
                code, printed = work.run(config=config)
                self.assertEqual(code, 1)
                self.assertIn(message, printed)
        self.assertEqual(work.take_log(), [])

    def test_a_second_run_in_the_same_folder(self):
        work = FLEET.work("twice", ["cam01"])
        os.mkdir(work.path("fleet"))
        with open(work.path("fleet/.lock"), "w", encoding="utf-8") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            code, printed = work.run()
        self.assertEqual(code, 1)
        self.assertIn("fleet: found another run that works in this folder", printed)


class Queue(unittest.TestCase):
    # Runs each job at once in the background, as a scheduler would.
    SUBMIT = "#!/bin/sh\n[ \"$1\" -ge 1 ] && [ \"$2\" -ge 300 ] && [ \"$3\" -ge 1 ] || exit 1\nsh \"$4\" </dev/null >>queue.log 2>&1 &\n"

    def test_the_generic_profile_gives_the_same(self):
        cameras = ["cam06", "broken"]
        work = FLEET.work("queue", cameras)
        with open(work.path("submit"), "w", encoding="utf-8") as file:
            file.write(self.SUBMIT)
        code, printed = work.run("--cluster", f"sh {work.path('submit')} {{threads}} {{resources.mem_mb}} {{resources.runtime}}",
                                 "--latency-wait", "5", profile="cluster")
        self.assertEqual(code, 0, printed)
        self.assertIn("2 cameras: 1 calibrated, 1 failed", printed)
        for name in ("corners/cam06.csv", "calibrations/cam06.yaml", "reports/cam06.html"):
            self.assertEqual(content(work.path("fleet", name)), content(REFERENCE.path("fleet", name)), name)
        self.assertEqual(sorted(work.take_log()), sorted(
            [("detect", "broken")] + [(step, "cam06") for step in ("detect", "calibrate", "validate", "report")] + 2 * [("fleet", "")]))


    def test_what_is_submitted_to_slurm(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in (("sbatch", 'echo "$*" >>submitted; echo 7'), ("squeue", "exit $(cat squeue_code)")):
                with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                    file.write(f"#!/bin/sh\n{text}\n")
                os.chmod(os.path.join(folder, name), 0o755)
            os.makedirs(os.path.join(folder, "steps/cam"))

            def submit(inputs, squeue_code):
                for name, text in (("steps/cam/inputs", inputs), ("squeue_code", str(squeue_code)), ("submitted", "")):
                    with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                        file.write(text)
                run = subprocess.run([os.path.join(WORKFLOW, "profiles/slurm/submit"), "1", "300", "2", "steps/cam/detect", "x.sh"],
                                     env=dict(os.environ, PATH=folder + ":" + os.environ["PATH"]), cwd=folder,
                                     capture_output=True, text=True, check=False)
                return run.returncode, run.stdout, content(os.path.join(folder, "submitted")).decode()

            first, again, other = submit("radtan", 0), submit("radtan", 0), submit("kannala_brandt", 0)
            self.assertEqual(first[:2], (0, "7\n"))
            self.assertEqual(first, again)
            self.assertEqual(other[:2], (0, "7\n"))
            self.assertNotEqual(first[2], other[2], "jobs of other settings have the same name")
            code, printed, submitted = submit("radtan", 1)  # the controller does not answer
            self.assertNotEqual(code, 0)
            self.assertEqual((printed, submitted), ("", ""))


class Table(unittest.TestCase):
    HEADER = "id,images,board\n"

    def test_what_is_wrong_is_named(self):
        cases = [
            ("", ":1: found no column 'id'; expected a header with id, images, board"),
            ("id,images\n", ":1: found no column 'board'"),
            ("id,images,bord\n", ":1: found the column 'bord'; expected 'board'"),
            ("id,images,board,board\n", ":1: found the column 'board' 2 times; expected each column once"),
            (self.HEADER, ":1: found no cameras; expected a row for each camera below the header"),
            (self.HEADER + "a,b\n", ":2: found 2 fields; expected 3, as in the header"),
            (self.HEADER + "\na,,c\n", ":3: images: found an empty field; expected a value"),
            (self.HEADER + "a/b,c,d\n", ":2: id: found 'a/b'; expected letters, digits, '.', '_' and '-'"),
            (self.HEADER + ".a,c,d\n", ":2: id: found '.a'"),
            (self.HEADER + "a" * 101 + ",c,d\n", ":2: id: found 'aaa"),
            (self.HEADER + "a,c,d\nA,c,d\n", ":3: id: found 'A', as in line 2; expected a different id for each camera"),
            (self.HEADER + 'a,"c\nd",e\n', ":3: images: found a control character; expected one line of text"),
            (self.HEADER + "a,b\x85c,d\n", ":2: images: found a control character"),
            (self.HEADER + 'a,"b"c,d\n', ":2: found a row that is no CSV"),
            (self.HEADER + "a,\udcff,d\n", "found bytes that are no UTF-8; expected a table in UTF-8"),
        ]
        num_checked = 0
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "cameras.csv")
            for text, message in cases:
                with open(path, "w", encoding="utf-8", errors="surrogateescape") as file:
                    file.write(text)
                with self.assertRaises(camera_table.TableError) as caught:
                    camera_table.read_table(path)
                self.assertIn(message, str(caught.exception))
                self.assertTrue(str(caught.exception).startswith(path + ":"))
                num_checked += 1
        self.assertEqual(num_checked, 15)

    def test_paths_are_relative_to_the_table(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "cameras.csv")
            with open(path, "w", encoding="utf-8-sig") as file:  # as a spreadsheet writes it
                file.write('board,id, images ,previous,model,tolerance\r\n"checkerboard:9x6:25mm",a, b c ,,,\r\n'
                           "target.yaml,d,/e,f.yaml#left,radtan,2px\r\n")
            first, second = camera_table.read_table(path)
        self.assertEqual(first, camera_table.Camera("a", os.path.join(folder, "b c"), "checkerboard:9x6:25mm"))
        self.assertEqual(second, camera_table.Camera("d", "/e", os.path.join(folder, "target.yaml"), "radtan", "2px",
                                                     os.path.join(folder, "f.yaml#left")))

    def test_names_with_unusual_characters(self):
        names = ["a\u2028b.png", "a\x85b.png", "a\x0cb.png", "a\u00a0b.png", "a b  c.png", "a\udcff.png", "a\rb.png"]
        with tempfile.TemporaryDirectory() as folder:
            images = os.path.join(folder, "une\u202ffois\u00a0deux")
            os.mkdir(images)
            for name in names:
                open(os.path.join(images, name), "w", encoding="utf-8").close()
            with open(os.path.join(folder, "cameras.csv"), "w", encoding="utf-8") as file:
                file.write(f"{self.HEADER}a,{os.path.basename(images)},c\n")
            camera, = camera_table.read_table(os.path.join(folder, "cameras.csv"))
            text = camera_table.dependencies(camera, [])
            self.assertEqual(camera_table.image_paths(text), sorted(os.path.join(images, name) for name in names))
            inputs = os.path.join(folder, "inputs")
            self.assertTrue(camera_table.write_if_changed(inputs, text))
            self.assertFalse(camera_table.write_if_changed(inputs, text))
            open(os.path.join(images, "a\nb.png"), "w", encoding="utf-8").close()
            with self.assertRaisesRegex(camera_table.TableError, "expected a name without line breaks"):
                camera_table.dependencies(camera, [])

    def test_a_photograph_that_becomes_readable_is_a_change(self):
        with tempfile.TemporaryDirectory() as folder:
            open(os.path.join(folder, "a.png"), "w", encoding="utf-8").close()
            camera = camera_table.Camera("a", folder, "c")
            readable = camera_table.dependencies(camera, [])
            with unittest.mock.patch("os.access", return_value=False):  # the test may run as root
                self.assertNotEqual(camera_table.dependencies(camera, []), readable)
            self.assertEqual(camera_table.dependencies(camera, []), readable)

    def test_image_files(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("a.JPG", "b.png", ".hidden.png", "notes.txt", "img0001.png", "img0002.png"):
                open(os.path.join(folder, name), "w", encoding="utf-8").close()
            os.mkdir(os.path.join(folder, "sub.png"))

            def names(images):
                return [os.path.basename(path) for path in camera_table.image_files(os.path.join(folder, images))]

            self.assertEqual(names(""), ["a.JPG", "b.png", "img0001.png", "img0002.png"])
            self.assertEqual(names("img%04d.png"), ["img0001.png", "img0002.png"])
            self.assertEqual(names("*.png"), ["b.png", "img0001.png", "img0002.png"])
            self.assertEqual(names("notes.txt"), ["notes.txt"])
            self.assertEqual(names("nothing"), [])


if __name__ == "__main__":
    simulated_fleet.require("snakemake")
    unittest.main(verbosity=2)
