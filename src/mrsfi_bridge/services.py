"""Services: who provides them, which calls wait for an answer. Knows no sockets."""

from asyncio import AbstractEventLoop, TimerHandle
from collections import Counter
from collections.abc import Callable, Hashable
from itertools import count
from typing import Any, NamedTuple, TypeAlias

from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.protocol import check_name
from mrsfi_bridge.settings import Limits, ServiceType, TypeTable

Ask: TypeAlias = Callable[[str, Any], None]
"""Passes a call on to its provider: identifier of the call, and the request."""

Reply: TypeAlias = Callable[[bool, Any], None]
"""Answers a caller: whether the call succeeded, and the response or the reason."""


_LONGEST_S = 3600.0

OWN: Hashable = "the server itself"
"""Provider of the services that nobody else may provide."""


class Service(NamedTuple):
    """A service and its provider."""

    type: ServiceType
    owner: Hashable
    ask: Ask


class Call(NamedTuple):
    """A call that waits for its answer; without a timer as long as it takes."""

    service: str
    type: ServiceType
    owner: Hashable
    caller: Hashable
    reply: Reply
    timer: TimerHandle | None


class Services:
    """Passes calls to providers and answers to callers; every call gets one answer.

    ``services`` has them by name, in the order in which they came.
    """

    noun = "service"
    _id = "service_request"

    def __init__(self, types: TypeTable, limits: Limits, scheduler: AbstractEventLoop) -> None:
        self._types = types
        self._limits = limits
        self._scheduler = scheduler
        self.services: dict[str, Service] = {}
        self._calls: dict[str, Call] = {}
        self._n_calls: Counter[Hashable] = Counter()
        self._numbers = count(1)

    def advertise(self, owner: Hashable, name: str, type_name: str, ask: Ask) -> bool:
        """Let a client provide a service; return whether another did before, whose place it takes.

        It is a ``ProtocolError`` if the type is unknown or the name is the server's own.
        """
        check_name(name, self.noun)
        service_type = self._typed(type_name)
        known = self.services.get(name)
        if known is None and len(self.services) >= self._limits.services:
            raise ProtocolError(
                f"{self.noun} '{name}': there are {self._limits.services}, the limit"
            )
        if known is not None and known.owner == OWN != owner:
            raise ProtocolError(f"service '{name}' is the server's own; choose another name")
        is_taken = known is not None and known.owner != owner
        if known is not None and is_taken:
            self._abandon(known.owner, name)
        self.services[name] = Service(service_type, owner, ask)
        return is_taken

    def unadvertise(self, owner: Hashable, name: str) -> None:
        """End a service, and answer those who wait for it.

        It is a ``ProtocolError`` if the client does not provide it.
        """
        known = self.services.get(name)
        if known is None or known.owner != owner:
            raise ProtocolError(f"{self.noun} '{name}' is not one that you advertised")
        del self.services[name]
        self._abandon(owner, name)

    def call(
        self, caller: Hashable, name: str, arguments: Any, reply: Reply, timeout_s: float = 0
    ) -> str:
        """Pass a call to its provider; whatever happens, ``reply`` takes one answer.

        ``arguments`` are the fields of the request by name, or in order. ``timeout_s`` is the time
        that the caller gives the provider, at most an hour; 0 leaves it to the server. It returns
        the identifier of the call, none if it was refused.
        """
        service = self.services.get(name)
        if service is None:
            reply(False, f"{self.noun.capitalize()} {name} does not exist")
            return ""
        if self._n_calls[caller] >= self._limits.uses:
            reply(False, f"{self._limits.uses} of your calls are under way, the limit")
            return ""
        try:
            request = service.type.request.convert(_named(arguments, service.type))
        except ProtocolError as error:
            reply(False, f"request of {self.noun} {name}: {error}")
            return ""
        call_id = f"{self._id}:{name}:{next(self._numbers)}"
        timer = self._timer(call_id, timeout_s)
        self._calls[call_id] = Call(name, service.type, service.owner, caller, reply, timer)
        self._n_calls[caller] += 1
        service.ask(call_id, request)
        return call_id

    def respond(self, owner: Hashable, call_id: Any, values: Any) -> None:
        """Pass the response of a provider to the caller.

        It is a ``ProtocolError`` if no such call waits, or the response does not fit the type of
        the service; the caller is told that, too.
        """
        call = self._taken(owner, call_id)
        try:
            response = call.type.response.convert(values)
        except ProtocolError as error:
            reason = f"response of {self.noun} {call.service}: {error}"
            call.reply(False, reason)
            raise ProtocolError(reason) from error
        call.reply(True, response)

    def refuse(self, owner: Hashable, call_id: Any, reason: str) -> None:
        """Tell the caller that the provider failed; ``ProtocolError`` if no such call waits."""
        self._taken(owner, call_id).reply(False, reason)

    def drop(self, call_id: str, reason: str) -> None:
        """Tell the caller that there will be no answer, unless it had one."""
        if call_id in self._calls:
            call = self._forget(call_id)
            call.reply(False, f"{self.noun.capitalize()} {call.service}: {reason}")

    def leave(self, client: Hashable) -> None:
        """End the services and the calls of a client, and answer those who wait for it."""
        for name in [name for name, known in self.services.items() if known.owner == client]:
            del self.services[name]
        for call_id in [key for key, call in self._calls.items() if call.caller == client]:
            self._forget(call_id)
        for call_id in [key for key, call in self._calls.items() if call.owner == client]:
            self.drop(call_id, "its provider left")
        del self._n_calls[client]

    def _typed(self, type_name: str) -> ServiceType:
        return self._types.service(type_name)

    def _timer(self, call_id: str, timeout_s: float) -> TimerHandle | None:
        """Return what ends a call that takes too long."""
        wait_s = min(timeout_s, _LONGEST_S) if timeout_s > 0 else self._limits.service_s
        reason = f"no answer within {wait_s:g} s"
        return self._scheduler.call_later(wait_s, lambda: self.drop(call_id, reason))

    def _abandon(self, owner: Hashable, name: str) -> None:
        for call_id, call in tuple(self._calls.items()):
            if call.owner == owner and call.service == name:
                self.drop(call_id, "its provider gave it up")

    def _taken(self, owner: Hashable, call_id: Any) -> Call:
        self._asked(owner, call_id)
        return self._forget(call_id)

    def _asked(self, owner: Hashable, call_id: Any) -> Call:
        """Return a call that a provider is asked to answer."""
        call = self._calls.get(call_id) if isinstance(call_id, str) else None
        if call is None or call.owner != owner:
            raise ProtocolError(f"no call {call_id!r:.100} waits for your answer")
        return call

    def _forget(self, call_id: str) -> Call:
        call = self._calls.pop(call_id)
        if call.timer is not None:
            call.timer.cancel()
        self._n_calls[call.caller] -= 1
        return call


def _named(arguments: Any, service_type: ServiceType) -> Any:
    """Return the fields of a request; a list gives them in order."""
    if not isinstance(arguments, list):
        return arguments
    fields = service_type.request.definition.fields
    if len(arguments) > len(fields):
        raise ProtocolError(f"{len(arguments)} arguments, expected at most {len(fields)}")
    return {field.name: value for field, value in zip(fields, arguments, strict=False)}
