"""A rosbridge server that needs no ROS: protocol, topics, services, rosapi, sockets.

``python -m mrsfi_bridge`` runs it; ``embedded.EmbeddedBridge`` runs it in a thread. It knows
nothing of missions and imports nothing of mrsfi.

Modules import only from those before them: ``errors``, ``structures`` (types of messages),
``settings`` (types, address, limits), ``frames`` (bytes), ``protocol`` (operations of a
client), ``broker`` (shared topics and services), ``session`` (one client), ``server`` (sockets)
and ``embedded`` (ways to run). Begin with ``session``.
"""
