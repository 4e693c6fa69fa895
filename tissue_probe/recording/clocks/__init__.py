"""Times: those that files and topics tell, made even or kept."""
