"""A Slurm cluster of one node, this machine, for tests: munged, slurmctld and slurmd of the calling user, everything in one folder."""
import os
import pathlib
import pwd
import signal
import socket
import subprocess
import time


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for each in sockets:
        each.bind(("", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


class OneNodeSlurm:
    """Started by `with`, stopped at its end, also after a failure; only processes it started are ended."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder).resolve()  # the daemons change directory: absolute
        self.node = socket.gethostname().split(".")[0]
        self.environment = dict(os.environ, SLURM_CONF=str(self.folder / "slurm.conf"))

    def __enter__(self):
        user = pwd.getpwuid(os.geteuid()).pw_name
        controller_port, node_port = free_ports(2)
        memory_mb = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2**20 * 9 // 10
        for name in ("state", "spool", "munge"):
            (self.folder / name).mkdir()
        (self.folder / "munge").chmod(0o755)
        (self.folder / "munge.key").write_bytes(os.urandom(64))
        (self.folder / "munge.key").chmod(0o600)
        # cred_expire is how long a requeued job waits, by default two minutes. Nothing here needs cgroups or a data base.
        (self.folder / "slurm.conf").write_text(f"""
ClusterName=one_node
SlurmctldHost={self.node}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={self.folder}/munge/socket,cred_expire=5
SlurmctldPort={controller_port}
SlurmdPort={node_port}
SlurmctldPidFile={self.folder}/slurmctld.pid
SlurmdPidFile={self.folder}/slurmd.pid
SlurmctldLogFile={self.folder}/slurmctld.log
SlurmdLogFile={self.folder}/slurmd.log
StateSaveLocation={self.folder}/state
SlurmdSpoolDir={self.folder}/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
SlurmdTimeout=10
KillWait=3
NodeName={self.node} NodeAddr=127.0.0.1 CPUs={os.cpu_count()} RealMemory={memory_mb} State=UNKNOWN
PartitionName=all Nodes={self.node} Default=YES State=UP
""")
        try:
            self._start("munged", "--force", f"--key-file={self.folder}/munge.key", f"--socket={self.folder}/munge/socket",
                        f"--pid-file={self.folder}/munged.pid", f"--log-file={self.folder}/munged.log", f"--seed-file={self.folder}/munge.seed")
            self._start("slurmctld", "-f", str(self.folder / "slurm.conf"))
            self.start_node()
            self.wait_for("idle", 30)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        if self.pid_of("slurmctld"):
            self.ask("scancel", "--partition=all")
            end = time.monotonic() + 15
            while self.ask("squeue", "--noheader") and time.monotonic() < end:
                time.sleep(0.1)
        for daemon in ("slurmd", "slurmctld", "munged"):
            self.stop(daemon, signal.SIGTERM)

    def _start(self, daemon, *arguments):
        """Each puts itself into the background once it works."""
        result = subprocess.run([f"/usr/sbin/{daemon}", *arguments], env=self.environment, capture_output=True, text=True, timeout=60)
        if result.returncode != 0:
            raise RuntimeError(f"{daemon} does not start: {result.stdout}{result.stderr}\n{self.log_of(daemon)}")

    def log_of(self, daemon):
        log = self.folder / f"{daemon}.log"
        return f"{log.name}:\n" + ("".join(log.read_text(errors="replace").splitlines(True)[-40:]) if log.exists() else "not written")

    def pid_of(self, daemon):
        try:
            return int((self.folder / f"{daemon}.pid").read_text())
        except (OSError, ValueError):
            return None

    def stop(self, daemon, how):
        pid = self.pid_of(daemon)
        if pid is None:
            return
        try:
            os.kill(pid, how)
            end = time.monotonic() + 10
            while time.monotonic() < end:
                os.kill(pid, 0)
                time.sleep(0.05)
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass

    def start_node(self):
        self._start("slurmd", "-f", str(self.folder / "slurm.conf"))

    def ask(self, *command):
        return subprocess.run(command, env=self.environment, capture_output=True, text=True, timeout=60).stdout.strip()

    def wait_for(self, state, seconds):
        """Until the node has a state that begins so: idle, mixed, down, ..."""
        end = time.monotonic() + seconds
        while not (found := self.ask("sinfo", "--noheader", "--format=%T")).startswith(state):
            if time.monotonic() > end:
                raise RuntimeError(f"the node is '{found}', needed '{state}'\n{self.log_of('slurmctld')}\n{self.log_of('slurmd')}")
            time.sleep(0.1)
