"""Recordings of ROS: bags of any storage, and topics of others in them."""
