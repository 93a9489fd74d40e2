"""The summary tells a session beside the last one that can be compared with it."""

import pytest

from tests.app.app_driver import AppDriver, OpenSession


async def to_comparison(driver: AppDriver) -> None:
    await driver.do_session()
    await driver.app.workers.wait_for_complete(
        [each for each in driver.app.workers if each.name == "comparison"]
    )
    await driver.settle()


@pytest.mark.slow
async def test_only_a_later_session_with_the_same_settings_has_a_comparison(
    open_session: OpenSession,
) -> None:
    compared = []
    for settings in ({}, {}, {"threshold": 900.0}):
        async with open_session(max_level=1, **settings) as driver:
            await to_comparison(driver)
            assert driver.sees("You did 2 attempts; goal reached in 2.")
            compared.append(driver.sees("Today 0.40 seconds, "))
    assert compared == [False, True, False]
