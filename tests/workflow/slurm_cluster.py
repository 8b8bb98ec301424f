# SPDX-License-Identifier: MIT
"""A Slurm of one machine in a folder of its own, for tests: munged, slurmctld and slurmd, ended together.

    with SlurmCluster(folder) as cluster:
        subprocess.run(["sbatch", ...], env=cluster.environment)

Configuration, keys, sockets, logs and state lie in the folder, and the ports are free ones, so that a Slurm of the
machine is neither used nor disturbed. No control groups and no systemd are needed.
"""
import os
import pwd
import shutil
import signal
import socket
import subprocess
import time

from simulated_fleet import end_with_parent

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "sacct", "scancel", "scontrol", "sinfo")
START_S = 60  # a start that takes longer has failed

CONFIGURATION = """\
ClusterName=alidade
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmdPort={node_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SlurmdParameters=config_overrides
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerParameters=sched_min_interval=100000,batch_sched_delay=0
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/none
MinJobAge=86400
KillWait=2
ReturnToService=2
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmdSpoolDir={folder}/node
StateSaveLocation={folder}/state
PlugStackConfig={folder}/plugstack.conf
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} Boards=1 SocketsPerBoard=1 CoresPerSocket={cpus} ThreadsPerCore=1 RealMemory={memory_mb} State=UNKNOWN
PartitionName=test Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def missing_programs():
    """The programs of Slurm and munge that this machine lacks."""
    path = search_path()
    return [name for name in PROGRAMS if not shutil.which(name, path=path)]


def search_path():
    return os.environ.get("PATH", "") + ":/usr/sbin:/sbin"


def free_ports(count):
    """Ports that nobody listens on; all are held until the last is found, so that they differ."""
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class SlurmCluster:
    """Starts the daemons on entry and ends them on exit, also where the start fails half-way."""

    def __init__(self, folder, num_cpus):
        self.folder = os.path.abspath(folder)
        self.num_cpus = min(num_cpus, os.cpu_count())  # of those that jobs may use
        self.daemons = []
        self.environment = dict(os.environ, PATH=search_path(), SLURM_CONF=self.path("slurm.conf"))

    def path(self, name):
        return os.path.join(self.folder, name)

    def __enter__(self):
        for attempt in range(3):
            try:
                self._start()
                return self
            except RuntimeError:  # somebody may have taken a port meanwhile
                self.stop()
                if attempt == 2:
                    raise
            except BaseException:
                self.stop()
                raise

    def __exit__(self, *_):
        self.stop()

    def _start(self):
        for name in (".", "node", "state"):
            os.makedirs(self.path(name), exist_ok=True)
        os.chmod(self.folder, 0o755)  # munged demands that all users reach its socket and nobody else writes beside it
        with open(os.open(self.path("munge.key"), os.O_CREAT | os.O_WRONLY, 0o600), "wb") as key:
            key.write(os.urandom(128))
        controller_port, node_port = free_ports(2)
        memory_mb = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2**20
        open(self.path("plugstack.conf"), "w").close()
        with open(self.path("slurm.conf"), "w", encoding="utf-8") as file:
            file.write(CONFIGURATION.format(
                host=socket.gethostname().split(".")[0], controller_port=controller_port, node_port=node_port,
                user=pwd.getpwuid(os.getuid()).pw_name, folder=self.folder, cpus=self.num_cpus, memory_mb=memory_mb))
        # From 23 on, slurmd ends without a control group unless it is told to do without.
        if int(self._run("sinfo", "--version").split()[1].split(".")[0]) >= 23:
            with open(self.path("cgroup.conf"), "w", encoding="utf-8") as file:
                file.write("CgroupPlugin=disabled\n")
        # A scratch folder lies below one that everybody may write to; --force accepts that.
        self._daemon("munged", "--foreground", "--force", "--num-threads=2", "--key-file", self.path("munge.key"),
                     "--socket", self.path("munge.socket"), "--pid-file", self.path("munge.pid"),
                     "--log-file", self.path("munge.log"), "--seed-file", self.path("munge.seed"))
        self._wait(lambda: os.path.exists(self.path("munge.socket")), "munged opens no socket")
        self._daemon("slurmctld", "-D", "-c")
        self._daemon("slurmd", "-D", "-N", socket.gethostname().split(".")[0])
        self._wait(lambda: self._run("sinfo", "-h", "-o", "%T").strip() == "idle", "the node does not become idle")

    def _daemon(self, name, *args):
        with open(self.path(name + ".out"), "wb") as log:
            self.daemons.append((name, subprocess.Popen(
                [shutil.which(name, path=search_path()), *args], cwd=self.folder, env=self.environment, stdout=log,
                stderr=log, stdin=subprocess.DEVNULL, start_new_session=True, preexec_fn=end_with_parent)))

    def _run(self, *command):
        return subprocess.run(command, env=self.environment, capture_output=True, text=True, timeout=60).stdout

    def _wait(self, is_done, what):
        limit = time.monotonic() + START_S
        while not is_done():
            ended = [name for name, daemon in self.daemons if daemon.poll() is not None]
            if ended or time.monotonic() > limit:
                raise RuntimeError(f"Slurm does not start: {what}; ended: {ended or 'none'}\n{self.logs()}")
            time.sleep(0.1)

    def logs(self):
        """The last lines of all logs."""
        text = ""
        for name in sorted(os.listdir(self.folder)):
            if name.endswith((".log", ".out")):
                with open(self.path(name), encoding="utf-8", errors="replace") as file:
                    text += f"--- {name}\n" + "".join(file.readlines()[-15:])
        return text

    def jobs(self):
        """The ids of all jobs that wait or run."""
        return self._run("squeue", "-h", "-o", "%A").split()

    def cancel_jobs(self):
        """Cancels all jobs and waits until none is left."""
        self._run("scancel", "--full", *(["-u", pwd.getpwuid(os.getuid()).pw_name]))
        limit = time.monotonic() + START_S
        while self.jobs() and time.monotonic() < limit:
            time.sleep(0.1)

    def stop(self):
        if len(self.daemons) == 3 and all(daemon.poll() is None for _, daemon in self.daemons):
            try:
                self.cancel_jobs()
            except subprocess.TimeoutExpired:
                pass
        for _, daemon in reversed(self.daemons):
            if daemon.poll() is None:
                daemon.send_signal(signal.SIGTERM)
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                os.killpg(daemon.pid, signal.SIGKILL)
                daemon.wait()
        self.daemons = []
