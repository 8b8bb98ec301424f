#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the workflow on a Slurm that it starts on this machine, and kills it on the way: slurm_test.py PROGRAM

The results must be those of a run without Slurm. Without the packages of Slurm the test is skipped (exit code 77).
"""
import os
import signal
import subprocess
import sys
import tempfile
import time

import simulated_fleet
from simulated_fleet import ALL, RENDERED, SimulatedFleet, content
from slurm_cluster import SlurmCluster, missing_programs

LIMIT_S = 120
NUM_CPUS = 2


def check(is_right, what):
    if not is_right:
        raise AssertionError(what)


def wait_for(condition, what):
    limit = time.monotonic() + LIMIT_S
    while not condition():
        check(time.monotonic() < limit, what)
        time.sleep(0.05)


def run_on(cluster, fleet):
    work = fleet.work("slurm")
    environment = dict(work.environment, SLURM_CONF=cluster.environment["SLURM_CONF"],
                       PATH=work.folder + ":" + cluster.environment["PATH"])

    def slurm(*command):
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout

    def jobs(state):
        return slurm("squeue", "-h", "-t", state, "-o", "%A").split()

    # The run is killed while its jobs wait and run. They are Slurm's and go on, but for one that is cancelled. Some are held
    # while they search, and the model of their cameras and of one that waits changes meanwhile.
    options = {"profile": "slurm", "environment": environment}
    open(work.path("hold"), "w", encoding="utf-8").close()
    run = work.start("--latency-wait", "10", **options)
    wait_for(lambda: run.poll() is not None or (work.printed().count("Submitted group job") == len(ALL) and work.records()),
             "no jobs run")
    work.set_trap("hold", "detect")
    num_free = len(work.calls())

    def held():
        return [camera for step, camera in work.calls()[num_free:] if step == "detect" and camera in RENDERED]

    wait_for(lambda: run.poll() is not None or held(), "no job is held")
    check(run.poll() is None, work.printed())
    os.killpg(run.pid, signal.SIGKILL)
    run.wait()
    work.set_trap()
    waiting = jobs("PENDING")
    check(waiting, "no job waits any more")
    slurm("scancel", waiting[-1])
    num_left = len(jobs("PENDING")) + len(jobs("RUNNING"))
    num_before = len(slurm("squeue", "-h", "-t", "all", "-o", "%A").split())
    changed = held()
    begun = {camera for _, camera in work.calls()}
    changed.append(next(name for name in RENDERED if name not in begun))
    for name in changed:
        work.set_row(name, model="kannala_brandt")
    done = {call for call in work.records() if call[1] not in changed}
    work.take_log()
    run = work.start("--latency-wait", "10", **options)
    wait_for(lambda: run.poll() is not None or "Resuming incomplete job" in work.printed(), "no job is resumed")
    os.remove(work.path("hold"))
    code = run.wait(LIMIT_S)
    printed = work.printed()
    check(code == 0, printed)
    check("12 cameras: " in printed and " 2 failed" in printed and "unfinished" not in printed, printed)
    repeated = [call for call in work.take_log() if call in done]
    check(not repeated, f"what was recorded was done again: {repeated}")
    # New jobs for the one that was cancelled and for those that were held. A job that runs may end while Snakemake starts,
    # and is not found then.
    num_new = len(slurm("squeue", "-h", "-t", "all", "-o", "%A").split()) - num_before
    check(len(changed) <= num_new <= len(changed) + NUM_CPUS,
          f"{num_new} jobs were submitted again, beside {num_left} that were left\n{printed}")
    check(not jobs("PENDING") and not jobs("RUNNING"), "jobs are left")
    for name in changed:
        with open(work.path("fleet/calibrations", name + ".yaml"), encoding="utf-8") as file:
            check("model: kannala_brandt" in file.read(), f"{name} has the old model")

    code, printed = work.run(profile="slurm", environment=environment)
    check(code == 0 and work.take_log() == [], printed)
    return work, num_left


def main():
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # by an exception, which ends the daemons
    simulated_fleet.require("snakemake")
    missing = missing_programs()
    if missing:
        simulated_fleet.skip(missing, "cluster")
    with tempfile.TemporaryDirectory(prefix="alidade-slurm-") as folder:
        fleet = SimulatedFleet(folder, sys.argv[1])
        with SlurmCluster(os.path.join(folder, "cluster"), num_cpus=NUM_CPUS) as cluster:
            try:
                work, num_left = run_on(cluster, fleet)
            except BaseException:
                print(cluster.logs())
                raise
        daemons = [pid for pid in os.listdir("/proc") if pid.isdigit() and runs_in(pid, folder)]
        check(not daemons, f"these processes are left: {daemons}")
        reference = fleet.work("reference")
        with open(reference.path("cameras.csv"), "wb") as table:
            table.write(content(work.path("cameras.csv")))
        code, printed = reference.run()
        check(code == 0, printed)
        expected, found = reference.outputs(), work.outputs()
        check(set(found) == set(expected), f"other files: {set(found) ^ set(expected)}")
        for name, text in expected.items():
            check(found[name] == text, f"{name} differs from the run without Slurm")
    print(f"{len(expected)} files are those of the run without Slurm; {num_left} jobs outlived the killed run")
    return 0


def runs_in(pid, folder):
    """Whether a process has the folder in its command line or works in it."""
    try:
        with open(f"/proc/{pid}/cmdline", "rb") as file:
            if folder.encode() in file.read():
                return True
        return os.readlink(f"/proc/{pid}/cwd").startswith(folder)
    except OSError:
        return False


if __name__ == "__main__":
    sys.exit(main())
