import operator

import pytest

from dynamics.errors import InvalidInput
from estimation.parallel import in_parallel


@pytest.mark.parametrize("workers", [1, 2])
def test_every_job_is_done_once_and_knows_its_number(workers: int) -> None:
    done = dict(in_parallel(operator.neg, [3, 1, 4, 1, 5], workers))
    assert done == {0: -3, 1: -1, 2: -4, 3: -1, 4: -5}


@pytest.mark.parametrize("workers", [1, 2])
def test_what_a_job_raises_reaches_the_caller(workers: int) -> None:
    with pytest.raises(ZeroDivisionError):
        dict(in_parallel(divmod_of, [1, 0], workers))


def divmod_of(divisor: int) -> tuple[int, int]:
    return divmod(7, divisor)


def test_dask_does_what_the_cores_do() -> None:
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 1, "threads_per_worker": 2, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster:
        done = dict(in_parallel(operator.neg, [3, 1, 4], scheduler=cluster.scheduler_address))
    assert done == {0: -3, 1: -1, 2: -4}


def test_an_address_without_a_scheduler_is_refused() -> None:
    pytest.importorskip("distributed")
    with pytest.raises(InvalidInput, match="--scheduler"):
        dict(in_parallel(operator.neg, [3, 1], scheduler="not an address"))
