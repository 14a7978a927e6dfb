"""Kernels that start at once and cannot take more than their share.

On Linux a kernel is forked from a process that has NumPy, SciPy, distmesh_edu and ipykernel loaded
already, which takes a tenth of the time, and is kept to a limit of memory. Elsewhere it is started
as Jupyter does it, and memory is not limited.
"""

import asyncio
import contextlib
import ctypes
import json
import os
import shutil
import signal
import sys
import tempfile
from pathlib import Path
from typing import Any

import psutil
from jupyter_client.connect import KernelConnectionInfo
from jupyter_client.manager import AsyncKernelManager
from jupyter_client.provisioning.local_provisioner import LocalProvisioner

FORKS = sys.platform == "linux"
MAX_WRITTEN = 200_000_000  # bytes of one file that a student's code writes
LONGEST_SOCKET = 100  # characters of its path; beyond, a kernel listens at ports
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "MALLOC_ARENA_MAX")


def quiet_environment(place: Path) -> dict[str, str]:
    """Return what kernels are to find: one thread each, and none of the teacher's own settings."""
    temporary = dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(place))
    return (
        dict.fromkeys(ONE_THREAD, "1")
        | temporary
        | {
            "IPYTHONDIR": str(place / "ipython"),
            "JUPYTER_RUNTIME_DIR": str(place / "runtime"),
            "JUPYTER_PREFER_ENV_PATH": "1",
            "PYTHONNOUSERSITE": "1",
            "NBGRADER_EXECUTION": "autograde",
        }
    )


class Nursery:
    """A folder of its own for one notebook, and a process that waits to become its kernel.

    To be made before anything else in its process: a fork wants a process with no other threads.
    """

    def __init__(self, memory: int, *, forks: bool = FORKS) -> None:
        self.place = Path(tempfile.mkdtemp(prefix="grade-"))
        self.work = self.place / "work"
        self.work.mkdir()
        self.memory = memory
        self.child, self.order = 0, -1
        if forks:
            _prctl(PR_SET_CHILD_SUBREAPER, 1)  # what a kernel leaves behind becomes our child
            _prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
            self.child, self.order = self._fork()

    def _fork(self) -> tuple[int, int]:
        read, write = os.pipe()
        child = os.fork()
        if child:
            os.close(read)
            return child, write
        code = 1
        try:
            os.setsid()
            _prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
            os.dup2(read, 3)
            os.closerange(4, 4096)
            _become_kernel(3, self.work, self.memory)
            code = 0
        finally:
            os._exit(code)

    def manager(self, **settings: Any) -> AsyncKernelManager:
        """Return what nbclient asks for a kernel."""
        if not self.child:
            return AsyncKernelManager(**settings)
        if len(str(self.place / "k-9")) < LONGEST_SOCKET:
            settings |= {"transport": "ipc", "ip": str(self.place / "k"), "cache_ports": False}
        manager = _Manager(connection_file=str(self.place / "connection.json"), **settings)
        manager.nursery = self
        return manager

    def close(self) -> None:
        """End whatever is left, and remove the folder."""
        with contextlib.suppress(OSError):
            os.close(self.order)
        for _ in range(20):  # what is killed may have started something in the meantime
            left = psutil.Process().children(recursive=True)
            if not left:
                break
            for one in left:
                with contextlib.suppress(psutil.Error):
                    one.kill()
            psutil.wait_procs(left, timeout=2)
            _reap()
        shutil.rmtree(self.place, ignore_errors=True)


class _Manager(AsyncKernelManager):
    nursery: Nursery

    async def _async_pre_start_kernel(self, **kw: Any) -> Any:
        self.provisioner = _Forked(
            kernel_id="forked", kernel_spec=self.kernel_spec, parent=self, nursery=self.nursery
        )
        return await super()._async_pre_start_kernel(**kw)


class _Forked(LocalProvisioner):
    """Tells the process that waits to become the kernel, in place of starting one."""

    def __init__(self, nursery: Nursery, **kw: Any) -> None:
        super().__init__(**kw)
        self.nursery = nursery

    async def launch_kernel(self, cmd: list[str], **_: Any) -> KernelConnectionInfo:
        connection = cmd[cmd.index("-f") + 1]
        os.write(self.nursery.order, json.dumps(connection).encode() + b"\n")
        self.process = _Process(self.nursery.child)
        self.pid = self.pgid = self.nursery.child
        return self.connection_info

    async def wait(self) -> int | None:
        while self.process and self.process.poll() is None:
            await asyncio.sleep(0.005)
        return await super().wait()


class _Process:
    """As much of subprocess.Popen as a provisioner asks of it."""

    stdin = stdout = stderr = None

    def __init__(self, pid: int) -> None:
        self.pid, self.returncode = pid, None

    def poll(self) -> int | None:
        return self._waited(os.WNOHANG)

    def wait(self) -> int | None:
        return self._waited(0)

    def _waited(self, how: int) -> int | None:
        if self.returncode is None:
            try:
                pid, status = os.waitpid(self.pid, how)
            except ChildProcessError:
                pid, status = self.pid, 0
            if pid:
                self.returncode = os.waitstatus_to_exitcode(status)
        return self.returncode

    def send_signal(self, number: int) -> None:
        if self.poll() is None:
            os.kill(self.pid, number)


def _become_kernel(order: int, work: Path, memory: int) -> None:
    """Wait for the order, and be a kernel until the end."""
    with os.fdopen(order) as wishes:
        line = wishes.readline()
    if not line:
        return
    import resource

    from ipykernel.kernelapp import IPKernelApp

    os.chdir(work)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nothing, stream)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (MAX_WRITTEN, MAX_WRITTEN))
    app = IPKernelApp.instance()
    app.initialize(["-f", json.loads(line), "--HistoryManager.enabled=False"])
    if memory:
        limit = psutil.Process().memory_info().vms + memory * 1_000_000
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    app.start()


def _prctl(option: int, value: int) -> None:
    ctypes.CDLL(None).prctl(option, value, 0, 0, 0)


def _reap() -> None:
    """Let go of children that have ended."""
    with contextlib.suppress(ChildProcessError):
        while FORKS and os.waitpid(-1, os.WNOHANG)[0]:
            pass


def interrupt(manager: AsyncKernelManager) -> None:
    """Interrupt what the kernel does, at once where that can be done."""
    pid = getattr(manager.provisioner, "pid", None)
    if FORKS and pid:
        with contextlib.suppress(OSError):
            os.killpg(os.getpgid(pid), signal.SIGINT)
    else:
        asyncio.ensure_future(manager.interrupt_kernel())  # noqa: RUF006  (awaited by the loop)


def memory_used(manager: AsyncKernelManager) -> int:
    """Return the bytes that a kernel holds, or 0 where there is none."""
    try:
        return psutil.Process(manager.provisioner.pid).memory_info().rss
    except (psutil.Error, AttributeError, ValueError, TypeError):
        return 0


def left_behind(manager: AsyncKernelManager) -> int:
    """Return how many processes a kernel has started that still run."""
    try:
        children = psutil.Process(manager.provisioner.pid).children(recursive=True)
        return sum(one.status() != psutil.STATUS_ZOMBIE for one in children)
    except (psutil.Error, AttributeError, ValueError, TypeError):
        return 0
