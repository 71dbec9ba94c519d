"""Flights as bags: MCAP files with the messages of ROS 2."""
