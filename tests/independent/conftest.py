from tests.support.own_metamodels import own_metamodels  # noqa: F401 - a fixture
