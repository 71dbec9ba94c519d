"""A rosbridge server that needs no ROS: protocol, topics, services, rosapi, sockets.

``python -m mrsfi_bridge`` runs it; ``embedded.EmbeddedBridge`` runs it in a thread. It knows
nothing of missions and imports nothing of mrsfi.
"""
