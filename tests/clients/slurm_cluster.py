"""A real scheduler for tests: slurmctld and two slurmd on this machine, of an ordinary user, on ports of their own."""
import ctypes
import os
import pwd
import signal
import socket
import subprocess
import time
from pathlib import Path

CONFIGURATION = """ClusterName=umax{controller_port}
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/none
CredType=cred/none
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
SchedulerParameters=sched_interval=2,bf_interval=2,batch_sched_delay=0
KillWait=2
SlurmctldPort={controller_port}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
{nodes}
PartitionName=farm Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def free_ports(count):
    """that nobody listens on now"""
    sockets = [socket.socket() for _ in range(count)]
    try:
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]
    finally:
        for one in sockets:
            one.close()


def end_with_parent():
    """a daemon goes when the test does, however that ends"""
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG


class Cluster:
    """Two nodes of one processor each, as long as the `with` lasts; nothing of it is left behind."""

    nodes = ["node1", "node2"]

    def __init__(self, folder):
        self.folder = Path(folder)
        self.daemons = []

    def __enter__(self):
        (self.folder / "state").mkdir(parents=True)
        ports = free_ports(1 + len(self.nodes))
        host = socket.gethostname().split(".")[0]
        lines = [f"NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs=1 RealMemory=500 State=UNKNOWN"
                 for node, port in zip(self.nodes, ports[1:])]
        configuration = self.folder / "slurm.conf"
        configuration.write_text(CONFIGURATION.format(folder=self.folder, host=host, controller_port=ports[0],
                                                      user=pwd.getpwuid(os.getuid()).pw_name, nodes="\n".join(lines)))
        self.environment = dict(os.environ, SLURM_CONF=str(configuration),
                                PATH=os.environ["PATH"] + ":/usr/sbin:/sbin")
        try:
            self.start(["slurmctld", "-D", "-c", "-f", configuration])
            for node in self.nodes:
                self.start(["slurmd", "-D", "-N", node, "-f", configuration])
            self.wait_for(lambda: self.call("sinfo", "--noheader", "--format=%t %D").split() == ["idle", "2"], 120,
                          "nodes that are idle")
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def start(self, words):
        output = open(self.folder / f"{words[0]}-{len(self.daemons)}.out", "w")
        self.daemons.append(subprocess.Popen([str(w) for w in words], env=self.environment, stdout=output,
                                             stderr=subprocess.STDOUT, preexec_fn=end_with_parent))

    def call(self, *words):
        """what a command of the queue says; nothing when it fails"""
        return subprocess.run(words, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              text=True).stdout

    def wait_for(self, condition, seconds, what):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise AssertionError(f"no {what} within {seconds} s\n{self.report()}")
            time.sleep(0.05)

    def report(self):
        """what the scheduler says, for who looks for a cause"""
        logs = sorted(self.folder.glob("*.log")) + sorted(self.folder.glob("*.out"))
        ends = "".join(f"--- {log.name}\n" + "\n".join(log.read_text(errors="replace").splitlines()[-15:]) + "\n"
                       for log in logs)
        return self.call("squeue", "--array") + self.call("sinfo") + ends

    def stop(self):
        """ends jobs first: what starts them is no child of ours"""
        if self.call("squeue", "--noheader"):
            self.call("scancel", "--user", pwd.getpwuid(os.getuid()).pw_name)
            end = time.monotonic() + 15
            while self.call("squeue", "--noheader") and time.monotonic() < end:
                time.sleep(0.05)
        for daemon in reversed(self.daemons):
            daemon.send_signal(signal.SIGTERM)
        for daemon in reversed(self.daemons):
            try:
                daemon.wait(timeout=10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
