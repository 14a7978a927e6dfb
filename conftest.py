"""The settings that tests/ and the notebooks of book/ share."""

pytest_plugins = ["tests.browser", "tests.scheduling", "tests.tolerance"]
