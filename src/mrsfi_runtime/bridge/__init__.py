"""The embedded rosbridge server: protocol, topics, services, rosapi, sockets."""
