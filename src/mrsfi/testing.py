"""Kept weaknesses as test cases of pytest."""

from collections.abc import Callable

from mrsfi.folders import find_mission
from mrsfi.regressions import all_kept, check_all
from mrsfi_runtime.record.engine_settings import AUTO, EngineSettings


def regression_test(
    mission: str, engine: str = AUTO, n_seeds: int | None = None
) -> Callable[[str], None]:
    """Return a test with a case for each weakness that is kept of a mission.

    Parameters
    ----------
    mission
        Name of a folder under ``models`` of the working folder, or the path of a mission folder.
    engine
        ``auto``, ``reference``, ``compiled`` or ``rosbridge``.
    n_seeds
        In how many mission seeds: those that are kept first, then others.

    Raises
    ------
    UsageError
        If there is no such mission, or nothing is kept of it: a suite of nothing is no pass.

    Examples
    --------
    In a file that pytest collects::

        from mrsfi.testing import regression_test

        test_what_was_found = regression_test("uuv_sampling")
    """
    import pytest  # noqa: PLC0415 - for tests alone

    folders = find_mission(mission)
    names = [regression.name for regression in all_kept(folders)]

    @pytest.mark.parametrize("weakness", names)
    def test_kept_weakness(weakness: str) -> None:
        (checked,) = check_all(folders, EngineSettings(engine), n_seeds=n_seeds, name=weakness)
        if checked.failure is not None:
            raise checked.failure
        found = f"came back: {checked.excess}; found in {checked.regression.found}"
        assert not checked.exceeded, "\n".join((found, *checked.why))

    return test_kept_weakness
