"""Many independent jobs, on all cores or on a Dask cluster."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing import active_children, connection, get_context, parent_process
from typing import TypeVar

from dynamics.errors import InvalidInput

Job = TypeVar("Job")
Result = TypeVar("Result")


def in_parallel(
    work: Callable[[Job], Result], jobs: Sequence[Job], workers: int = 0, scheduler: str = ""
) -> Iterator[tuple[int, Result]]:
    """Yield the number and the result of every job, as they get done.

    The processes end with this one, even when it is killed; a KeyboardInterrupt here ends them at once.

    Args:
        work: a function of a module, that can be pickled; what it raises is raised here.
        jobs: what it is called with, each by itself.
        workers: processes; 0 for one a core, and 1 for this process itself.
        scheduler: address of a Dask scheduler, instead.

    Raises:
        InvalidInput: if there is no Dask, or no scheduler at the address.
    """
    if not scheduler and (workers == 1 or len(jobs) == 1):
        for number, job in enumerate(jobs):
            yield number, work(job)
        return
    others = set(active_children())
    with _executor(workers or os.cpu_count() or 1, scheduler) as executor:
        with _deaf_to_interrupts():
            futures: dict[Future[Result], int] = {
                executor.submit(work, job): number for number, job in enumerate(jobs)
            }
        try:
            for future in as_completed(futures):
                yield futures[future], future.result()
        except KeyboardInterrupt:
            for process in set(active_children()) - others:
                process.terminate()
            raise
        finally:
            for future in futures:
                future.cancel()


@contextmanager
def _executor(workers: int, scheduler: str) -> Iterator[Executor]:
    if not scheduler:
        with ProcessPoolExecutor(workers, get_context("spawn"), initializer=_end_with_parent) as pool:
            yield pool
        return
    try:
        from distributed import Client
    except ImportError:
        raise InvalidInput("--scheduler", scheduler, "an installed Dask: pip install palpate[dask]") from None
    try:
        client = Client(scheduler, timeout=10)
    except (OSError, ValueError) as error:
        raise InvalidInput("--scheduler", scheduler, f"the address of a Dask scheduler ({error})") from None
    with client:
        yield client.get_executor()


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Hold Ctrl-C back, also from processes begun meanwhile: a terminal sends it to all, this one handles it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_with_parent() -> None:
    """End this process when its parent does: one that is killed cannot tell its workers."""
    parent = parent_process()
    if parent is None:
        return
    sentinel = parent.sentinel

    def wait() -> None:
        connection.wait([sentinel])
        os._exit(1)

    threading.Thread(target=wait, name="waits for the parent", daemon=True).start()
