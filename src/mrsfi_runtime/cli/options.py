"""Options of a command that it receives together, as one value."""

from collections.abc import Callable, Sequence
from dataclasses import fields
from functools import wraps
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable[..., Any])


def options_as(
    name: str, kind: type[Any], options: Sequence[Callable[[Any], Any]]
) -> Callable[[F], F]:
    """Return the decorator that gives a command options, and passes them as one argument.

    Parameters
    ----------
    name
        Of the argument.
    kind
        Its dataclass; its fields are named as the parameters of the options.
    options
        Decorators of click, in the order of the help.
    """

    def decorate(command: F) -> F:
        @wraps(command)
        def collected(*arguments: Any, **given: Any) -> Any:
            value = kind(**{field.name: given.pop(field.name) for field in fields(kind)})
            return command(*arguments, **{name: value}, **given)

        decorated: Any = collected
        for option in reversed(options):
            decorated = option(decorated)
        return cast("F", decorated)

    return decorate
